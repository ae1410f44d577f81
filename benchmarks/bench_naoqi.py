"""Measure the virtual NAO under load: latency of a call, memory, and whether every call gets its own answer.

Four scripts in separate processes call one server 100 000 times: they read and set angles, and write values to the
robot's memory and read them back. Then hundreds of sessions are opened and dropped, some in the middle of a call. A
plain qi server, with a method that returns its arguments, is measured in the same run, and latencies are given as
ratios to it.

The exit code is 1 if an answer is lost or belongs to another call, or if the server's memory grows.

Example:
    python benchmarks/bench_naoqi.py --calls 100000 --sessions 1000
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

CLIENTS = 4
# The server's memory may differ by this much between two rounds of equal work [MiB].
MOST_GROWTH = 8.0

BARE = """
    import sys, threading, qi
    qi.logging.setLevel(qi.logging.FATAL)
    @qi.multiThreaded()
    class Echo:
        def getAngles(self, *arguments):
            return list(arguments)
    session = qi.Session()
    session.listenStandalone("tcp://127.0.0.1:0")
    session.registerService("ALMotion", Echo())
    print(session.endpoints()[0], flush=True)
    threading.Event().wait()
"""

LATENCY = """
    import json, sys, time, qi
    qi.logging.setLevel(qi.logging.FATAL)
    session = qi.Session()
    session.connect(sys.argv[1])
    motion = session.service("ALMotion")
    taken = []
    for _ in range(int(sys.argv[2])):
        start = time.perf_counter()
        motion.getAngles("HeadYaw", True)
        taken.append(time.perf_counter() - start)
    print(json.dumps(taken))
"""

CLIENT = """
    import json, sys, time, qi
    qi.logging.setLevel(qi.logging.FATAL)
    endpoint, number, calls = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    session = qi.Session()
    session.connect(endpoint)
    motion, memory = session.service("ALMotion"), session.service("ALMemory")
    joints = ["HeadYaw", "HeadPitch", "LElbowYaw", "RElbowYaw"]
    taken, wrong = [], 0
    for i in range(calls):
        start = time.perf_counter()
        if i % 4 == 0:
            memory.insertData("Demo/Client%d" % number, [number, i])
        elif i % 4 == 1:
            wrong += memory.getData("Demo/Client%d" % number) != [number, i - 1]
        elif i % 4 == 2:
            motion.setAngles(joints[number], 0.001 * (i % 300), 0.5)
        else:
            names = joints[: 1 + number]
            wrong += len(motion.getAngles(names, True)) != len(names)
        taken.append(time.perf_counter() - start)
    print(json.dumps({"taken": taken, "wrong": wrong}))
"""

SESSIONS = """
    import os, sys, qi
    qi.logging.setLevel(qi.logging.FATAL)
    endpoint, count = sys.argv[1], int(sys.argv[2])
    wrong = 0
    for i in range(count):
        session = qi.Session()
        session.connect(endpoint)
        motion = session.service("ALMotion")
        wrong += len(motion.getAngles("Body", True)) != 26
        if i % 3 == 0:
            motion.angleInterpolation("LWristYaw", 0.1, 0.5, True, _async=True)  # dropped in the middle of it
        if i % 2:
            session.close()
    print(wrong, flush=True)
    os._exit(0)  # as a script that crashes: nothing is closed
"""


@contextmanager
def serving(command: list[str]) -> Iterator[tuple[str, int]]:
    """Start a server, yield its endpoint and its process, and end it afterwards."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            text = process.stdout.readline()
            while text.startswith("{") and not text.rstrip().endswith("}"):
                text += process.stdout.readline()
            yield json.loads(text)["endpoint"] if text.startswith("{") else text.split()[0], process.pid
        finally:
            process.kill()


def program(text: str, *arguments: object) -> list[str]:
    """Return the command that runs a small program."""
    return [sys.executable, "-c", textwrap.dedent(text), *map(str, arguments)]


def resident(process: int) -> float:
    """Return the resident memory of a process [MiB]."""
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024.0
    return 0.0


def quantile(values: list[float], share: float) -> float:
    """Return the value that a given share of all values does not exceed."""
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def load(endpoint: str, calls: int) -> tuple[list[float], int]:
    """Return the time of each call of all clients, and the number of wrong answers."""
    running = [
        subprocess.Popen(program(CLIENT, endpoint, number, calls // CLIENTS), stdout=subprocess.PIPE, text=True)
        for number in range(CLIENTS)
    ]
    found = [json.loads(client.communicate()[0]) for client in running]
    return [second for one in found for second in one["taken"]], sum(one["wrong"] for one in found)


def main() -> None:
    """Measure, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=100_000)
    parser.add_argument("--sessions", type=int, default=1000)
    arguments = parser.parse_args()

    def latency(endpoint: str) -> list[float]:
        done = subprocess.run(program(LATENCY, endpoint, 2000), capture_output=True, text=True, check=True)
        return list(json.loads(done.stdout))

    with (
        serving(program(BARE)) as (bare, _),
        serving([sys.executable, "-m", "nao_kin", "serve", "--port", "0", "--json"]) as (ours, process),
    ):
        alone, with_robot = latency(bare), latency(ours)
        ratio = quantile(with_robot, 0.5) / quantile(alone, 0.5)
        print(
            f"one client, getAngles: median {1e6 * quantile(with_robot, 0.5):.0f} µs, bare qi "
            f"{1e6 * quantile(alone, 0.5):.0f} µs, ratio {ratio:.2f}"
        )
        load(ours, max(4000, arguments.calls // 10))  # objects that are created only once exist now
        before = resident(process)
        taken, wrong = load(ours, arguments.calls)
        after = resident(process)
        print(
            f"{CLIENTS} clients, {len(taken)} calls: median {1e6 * quantile(taken, 0.5):.0f} µs, p99 "
            f"{1e3 * quantile(taken, 0.99):.2f} ms, most {1e3 * max(taken):.1f} ms, wrong answers {wrong}"
        )
        print(f"memory {before:.1f} MiB before, {after:.1f} MiB after")
        half = arguments.sessions // 2
        lost = int(subprocess.run(program(SESSIONS, ours, half), capture_output=True, text=True, check=True).stdout)
        middle = resident(process)
        lost += int(subprocess.run(program(SESSIONS, ours, half), capture_output=True, text=True, check=True).stdout)
        end = resident(process)
        print(
            f"{2 * half} sessions opened and dropped: {lost} wrong answers, memory {middle:.1f} MiB after half of "
            f"them, {end:.1f} MiB after all"
        )
        alive = len(latency(ours)) == 2000
    bad = wrong or lost or not alive or after - before > MOST_GROWTH or end - middle > MOST_GROWTH
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
