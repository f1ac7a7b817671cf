#!/bin/bash
# Tries a sweep on HyperQueue on this machine alone: 200 tasks, one killed, a worker killed; then how many scenes a
# second it does beside a plain sweep. With the program `hq` where there is one, else with HyperQueue's Python wheel,
# which it installs where it can; its server and workers are one process.
# Usage: tests/engines/hyperqueue.sh [PROGRAM]
set -u
PROGRAM=$(readlink -f "${1:-target/release/tyrewave}")
here=$(cd "$(dirname "$0")" && pwd)
source "$here/common.sh"
[ -x "$PROGRAM" ] || skip "there is no $PROGRAM"
WORK=$(mktemp -d /tmp/tyrewave-hq.XXXXXX)
export TYREWAVE_CACHE_DIR=$WORK/cache HQ_SERVER_DIR=$WORK/server
started=()
trap 'kill "${started[@]}" 2> /dev/null; wait 2> /dev/null; rm -rf "$WORK"' EXIT
if command -v hq > /dev/null; then
    engine=$(hq --version)
    hq server start --host 127.0.0.1 > "$WORK/server.log" 2>&1 &
    started+=($!)
    until hq server info > /dev/null 2>&1; do sleep 0.1; done
    worker() { hq worker start --cpus 1 --heartbeat 1s > "$WORK/worker-$1.log" 2>&1 & worker=$!; started+=("$worker"); }
    worker 1
    worker 2
    submit() { bash "$1/job.hq" ${2:+"$2"} > /dev/null || fail "hq submit"; }
    finish() { hq job wait all > /dev/null 2>&1; }
    again() { worker 3; }
else
    python3 -m venv "$WORK/venv" > /dev/null 2>&1 && "$WORK/venv/bin/pip" install -q hyperqueue > /dev/null 2>&1 ||
        skip "there is no hq, and pip has no hyperqueue"
    engine="$("$WORK/venv/bin/python" -c 'import hyperqueue; print(hyperqueue.get_version())') (wheel)"
    submit() {
        "$WORK/venv/bin/python" "$here/hyperqueue_wheel.py" "$PROGRAM" "$@" > "$WORK/wheel.log" 2>&1 &
        first=$!
        started+=("$first")
        last=("$@")
    }
    finish() { wait "$first" 2> /dev/null; }
    again() { finish; sleep 2; submit "${last[@]}"; }
fi
echo "HyperQueue: $engine, $(nproc) processors; $("$PROGRAM" --version)"

begin=$(now)
"$PROGRAM" sweep "${trial[@]}" --out "$WORK/plain" --quiet > /dev/null || fail "the plain sweep"
echo "plain sweep of 200 scenes: $(since "$begin") s"
tasks=$WORK/tasks
"$PROGRAM" sweep "${trial[@]}" --tasks "$tasks" --chunk 1 --quiet || fail "writing tasks"
begin=$(now)
submit "$tasks"
until_done "$tasks" 20
kill_one "$tasks"
until_done "$tasks" 60
hold_one "$tasks"
kill -KILL "$(ps -o ppid= -p "$pid" | tr -d ' ')"
kill -CONT "$pid"
echo "killed the worker of task $number"
again
finish
"$PROGRAM" sweep --collect "$tasks" --quiet > /dev/null 2> "$WORK/told" || cat "$WORK/told"
if [ -e "$tasks/missing" ]; then
    submit "$tasks" "$(cat "$tasks/missing")"
    finish
fi
echo "200 tasks with all that: $(since "$begin") s"
cat "$tasks"/logs/* > "$WORK/log"
check "$tasks" "$WORK/log"

by_engine() { submit "$1" && finish; }
throughput HyperQueue "${CHUNK:-25}"
