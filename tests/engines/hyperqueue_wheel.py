"""What job.hq submits, by HyperQueue's Python wheel: hyperqueue_wheel.py PROGRAM FOLDER [ELEMENTS]."""

import re
import subprocess
import sys
from pathlib import Path

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

folder = Path(sys.argv[2])
script = (folder / "job.hq").read_text()
# The submission as it stands there; the shell takes its words apart, and shows them where `hq` would be run.
shown = "exec() { shift 2; printf '%s\\0' \"$@\"; }\n" + script
elements = sys.argv[3:4]
words = subprocess.run(["bash", "-c", shown, "job.hq", *elements], check=True, capture_output=True).stdout
words = words.decode().split("\0")[:-1]
array = words[words.index("--array") + 1]
command = words[words.index("--") + 1 :]
crashes = int(words[words.index("--crash-limit") + 1])

job = Job(max_fails=None)
for part in array.split(","):
    first, last = re.fullmatch(r"(\d+)(?:-(\d+))?", part).groups()
    for element in range(int(first), int(last or first) + 1):
        log = folder / "logs" / f"{element}.txt"
        # Logs of an earlier attempt stay.
        args = ["bash", "-c", f'exec "$@" >> "{log}" 2>&1', "element", *command]
        env = {"HQ_TASK_ID": str(element)}
        job.program(args, env=env, stdout=None, stderr=None, crash_limit=crashes)
with LocalCluster(worker_config=WorkerConfig()) as cluster:
    client = cluster.client()
    client.wait_for_jobs([client.submit(job)], raise_on_error=False)
