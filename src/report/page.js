// Beside the pointer, or the finger: what the element under it says in its title.
(() => {
  const told = document.getElementById("told");
  const title = (element) => element.closest?.(".picture svg *")?.querySelector?.(":scope > title");
  const show = (event) => {
    const text = title(event.target)?.textContent;
    told.hidden = !text;
    if (!text) return;
    told.textContent = text;
    const room = { x: innerWidth - told.offsetWidth - 8, y: innerHeight - told.offsetHeight - 8 };
    told.style.left = Math.max(8, Math.min(event.clientX + 14, room.x)) + "px";
    told.style.top = Math.max(8, Math.min(event.clientY + 14, room.y)) + "px";
  };
  addEventListener("pointermove", show);
  addEventListener("pointerdown", show);
  addEventListener("scroll", () => { told.hidden = true; }, { passive: true });
})();
