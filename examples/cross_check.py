"""Check the conventions yourself.

Learn how to compare every convention of this library with Pinocchio, eigenpy and yourdfpy, on your own machine and with
your own robot.
"""

import nao_kin as nk
from nao_kin import crosscheck

report = crosscheck.run(nk.load_nao(), samples=10)
print("all conventions agree to their tolerances:", report.ok)
print("for instance")
for row in report.rows:
    if row.convention in ("poses from elementary rotations", "rot_x", "exp", "log"):
        print(f"  {row.convention} against {row.against}: {'ok' if row.worst <= row.tolerance else 'not ok'}")
