"""Check the pinned versions of `constraints.txt` for known vulnerabilities, with pip-audit.

Exit status 1: a pinned version is vulnerable. 3: the vulnerability service has not answered for every version.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

CONSTRAINTS = Path(__file__).resolve().parents[1] / "constraints.txt"
UNKNOWN = 3


def main(constraints: Path = CONSTRAINTS) -> int:
    """Print the vulnerabilities; return the exit status."""
    command = [sys.executable, "-m", "pip_audit", "--requirement", constraints, "--no-deps", "--disable-pip"]
    ended = subprocess.run([*command, "--format", "json"], capture_output=True, text=True, check=False)
    pinned = re.findall(r"^([\w.-]+)==", constraints.read_text(encoding="utf-8"), re.MULTILINE)
    found = json.loads(ended.stdout)["dependencies"] if ended.stdout else []
    audited = [each for each in found if "vulns" in each]
    vulnerable = [each for each in audited if each["vulns"]]
    for each in vulnerable:
        for known in each["vulns"]:
            fixed = ", ".join(known["fix_versions"]) or "no version yet"
            print(f"{each['name']} {each['version']} has {known['id']}, fixed in {fixed}")
    if missing := len(pinned) - len(audited):
        reason = next((each["skip_reason"] for each in found if "skip_reason" in each), ended.stderr.strip()[-200:])
        print(f"NOT AUDITED: {missing} of the {len(pinned)} versions in {constraints.name}. The first reason: {reason}")
    else:
        print(f"Audited: {len(pinned)} versions in {constraints.name}, {len(vulnerable)} with known vulnerabilities")
    return 1 if vulnerable else UNKNOWN if missing else 0


if __name__ == "__main__":
    sys.exit(main())
