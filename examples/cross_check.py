"""Do not believe, check.

Learn how every convention of this library is compared with Pinocchio, eigenpy and yourdfpy on your own machine.
"""

import nao_kin as nk
from nao_kin import crosscheck

report = crosscheck.run(nk.load_nao(), samples=10)
print(f"{len(report.rows)} conventions compared, all within their tolerances: {report.ok}")
for row in report.rows[:12]:
    print(f"{'ok ' if row.worst <= row.tolerance else 'BAD'} {row.convention} against {row.against}")
print("…")
