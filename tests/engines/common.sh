# What the scripts beside it share; they set WORK, a folder of their own, and PROGRAM.

skip() { echo "skipped: $*"; exit 0; }
fail() { echo "FAILED: $*"; exit 1; }
now() { date +%s.%N; }
since() { awk -v a="$1" -v b="$(now)" 'BEGIN { printf "%.1f", b - a }'; }

# The scenes of the trial: 200, each of so many seconds of rolling that a process lives long enough to be killed, with a
# checkpoint every 0.2 s; and 1000 short ones.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scene=("$root/scenes/default.toml" --set numerics.elements=64 --set rolling.warm_up=0.2
    --set rolling.axle.tolerance=0.9)
trial=("${scene[@]}" --set "rolling.duration=${SECONDS_ROLLED:-20.0}" --set outputs.checkpoint_interval=0.1
    --speed 50..99.5:0.5 --load 3000,3400)
many=("${scene[@]}" --set rolling.duration=0.4 --speed "50..99.9:${MANY_STEP:-0.1}" --load 3000,3400)

# Tasks that were held, each to be killed, or put back into the queue.
held=()

# Finds a process that does a task and has renewed its checkpoint, the first of which is of the beginning, and holds it:
# its id, the task's number, the checkpoint's age.
hold_one() {
    local checkpoint lock
    local -A first=()
    for _ in $(seq 1000); do
        sleep 0.02
        for pid in $(pgrep -f -- "sweep --task $1" || true); do
            checkpoint=$(find "$1" -name checkpoint -path "*partial*-$pid/*" -printf '%T@ %p\n' 2> /dev/null | head -1)
            [ -n "$checkpoint" ] && : "${first[$pid]:=$checkpoint}" && [ "$checkpoint" != "${first[$pid]}" ] || continue
            lock=$(find "/proc/$pid/fd" -lname '*/lock-*' -printf '%l\n' 2> /dev/null | head -1)
            [ -n "$lock" ] && kill -STOP "$pid" 2> /dev/null || continue
            number=${lock##*/lock-}
            checkpoint=${checkpoint#* }
            age=$(awk -v a="$(stat -c %.Y "$checkpoint" 2> /dev/null)" -v b="$(now)" 'BEGIN { printf "%.2f", b - a }')
            [ -e "$checkpoint" ] && held+=("$number") && return 0
            kill -CONT "$pid"
        done
    done
    fail "no task with a checkpoint was found"
}

outcomes() { find "$1" -name 'outcome-*' ! -name '*.tmp' | wc -l; }

# Waits until so many tasks of a folder are done.
until_done() {
    for _ in $(seq 600); do
        [ "$(outcomes "$1")" -ge "$2" ] && return 0
        [ -e "$1/shard-0000/outcomes" ] && return 0
        sleep 0.5
    done
    fail "no more than $(outcomes "$1") tasks were done in time"
}

# Kills, without a warning, a task's process; says how much of its work is lost.
kill_one() {
    hold_one "$1"
    kill -KILL "$pid"
    echo "killed the process of task $number: its checkpoint was $age s old"
    awk -v age="$age" 'BEGIN { exit !(age < 1.0) }' || fail "the checkpoint is older than its interval"
}

# Whether all tasks are done, each once, to the bytes of the plain sweep.
check() {
    "$PROGRAM" sweep --collect "$1" --quiet > /dev/null || fail "tasks are missing"
    cmp "$1/sweep.csv" "$WORK/plain/sweep.csv" || fail "the table is not that of the plain sweep"
    local count doubled
    count=$(grep -ahoE 'task [0-9]+ \([^)]*\): done$' "$2" | wc -l)
    doubled=$(grep -ahoE 'task [0-9]+ \([^)]*\): done$' "$2" | sort | uniq -d | wc -l)
    echo "done: $count tasks, $doubled of them twice; continued: $(grep -ahc 'continues at' "$2"), the table is the" \
        "plain sweep's"
    grep -aho 'task .*continues at.*' "$2" | sed 's/^/  /' || true
    [ "$count" = 200 ] && [ "$doubled" = 0 ] || fail "not every task was done once"
    local number
    for number in "${held[@]}"; do
        grep -aq "task $number .*continues at" "$2" || fail "task $number was done again from its beginning"
    done
}

# How long many short scenes take, plain and by an engine whose elements are so many tasks; `by_engine` submits a folder
# of tasks and waits until they are done.
throughput() {
    local engine=$1 chunk=$2 tasks=$WORK/short begin
    begin=$(now)
    "$PROGRAM" sweep "${many[@]}" --out "$WORK/many" --quiet > /dev/null || fail "the plain sweep of many"
    echo "plain sweep of many short scenes: $(since "$begin") s"
    begin=$(now)
    "$PROGRAM" sweep "${many[@]}" --tasks "$tasks" --chunk "$chunk" --quiet || fail "writing tasks"
    echo "writing them as tasks: $(since "$begin") s, $(du -sk "$tasks" | cut -f1) kB"
    begin=$(now)
    by_engine "$tasks"
    echo "by $engine in elements of $chunk: $(since "$begin") s"
    begin=$(now)
    "$PROGRAM" sweep --collect "$tasks" --quiet > /dev/null || fail "collecting"
    echo "collecting: $(since "$begin") s; $(find "$tasks" -type f | wc -l) files, $(du -sk "$tasks" | cut -f1) kB"
    cmp "$tasks/sweep.csv" "$WORK/many/sweep.csv" || fail "the table is not that of the plain sweep"
}
