"""Plans: forecasts of runs."""

from typing import Any


class Plan:
    """Forecast of a run: its work with reasons, and its cost on this machine; nothing is simulated for it.

    `record` is all of it as `tyrewave plan --json` prints it.
    """

    def __init__(self, record: dict[str, Any]) -> None:
        self.record = record

    @property
    def sizes(self) -> dict[str, Any]:
        """Speed [m/s], elements, length of one [m], time step [s], steps, and what is expected of the contact."""
        return dict(self.record["sizes"])

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Which effects the scene calls for, and why."""
        return list(self.record["effects"])

    @property
    def choices(self) -> list[dict[str, Any]]:
        """Choices where the scene leaves them open: key, value, reason."""
        return list(self.record["choices"])

    @property
    def notes(self) -> list[str]:
        """Remarks to read before a run."""
        return list(self.record["notes"])

    @property
    def forecast(self) -> dict[str, Any]:
        """Time of each stage and `wall_seconds` of all [s], largest `memory` [bytes], on so many `threads`."""
        return dict(self.record["forecast"])

    def __repr__(self) -> str:
        sizes, forecast = self.sizes, self.forecast
        return (
            f"<tyrewave.Plan: {sizes['elements']} elements of {1e3 * sizes['element']:.2f} mm, {sizes['steps']} steps "
            f"of {1e6 * sizes['time_step']:.1f} us; about {forecast['wall_seconds']:.1f} s on {forecast['threads']} "
            f"threads and {1e-6 * forecast['memory']:.0f} MB>"
        )
