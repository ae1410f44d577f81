"""From a log to the paths of the hands.

Learn how to convert a file of joint angles of any length to a file of poses, and how bad rows are reported.
"""

import csv
import sys
import tempfile
from pathlib import Path

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
rows = np.linspace(nao.posture("StandInit"), nao.posture("Stand"), 1000)

with tempfile.TemporaryDirectory() as temporary:
    log, hands = Path(temporary) / "log.csv", Path(temporary) / "hands.csv"
    np.savetxt(log, rows, delimiter=",", header=",".join(nao.joint_names), comments="")
    with log.open("a") as end:
        end.write("0.1,0.2\n")  # an incomplete row, as if the robot was switched off

    try:
        done = nk.stream.fk(nao, log, hands, frame=["LArm", "RArm"], as_="rpy", on_error="skip")
    except nk.errors.MissingExtra as error:
        sys.exit(str(error))
    print(f"{done.rows_read} rows read, {done.rows_written} written, {done.bad_rows} bad")
    for bad in done.first_bad_rows:
        print(f"line {bad.line}: {bad.reason}")

    with hands.open() as file:
        found = list(csv.DictReader(file))
    for record in (*found[:2], *found[-2:]):
        print(record["row"], record["frame"], *(f"{name} = {float(record[name]):.4f}" for name in ("x", "y", "z")))
