"""Run a command and tell what it needed, as JSON: `python -m bench.process COMMAND…`.

A process of its own, because the kernel counts a process' memory from its fork on: a child of a program that holds a gigabyte
has needed a gigabyte before it has begun. This one imports next to nothing.
"""

import json
import resource
import subprocess
import sys
import time

begin = time.perf_counter()
run = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
seconds = time.perf_counter() - begin
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
needed = {
    "seconds": seconds,
    "processor": usage.ru_utime + usage.ru_stime,
    "memory": usage.ru_maxrss / 1024.0,
    "output": run.stdout,
    "code": run.returncode,
}
print(json.dumps(needed))
