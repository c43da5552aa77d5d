"""The audit of CI checks every pinned version and reports each version that it cannot check."""

import json
import runpy
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CI = runpy.run_path(str(ROOT / ".ci" / "audit.py"))

CLEAN = {"name": "numpy", "version": "2.4.6", "vulns": []}
VULNERABLE = {"name": "pillow", "version": "11.3.0", "vulns": [{"id": "CVE-2026-25990", "fix_versions": ["12.1.1"]}]}
SKIPPED = {"name": "pillow", "skip_reason": "not on PyPI"}


@pytest.mark.parametrize(
    "found, status, told",
    [
        ([CLEAN, {**VULNERABLE, "vulns": []}], 0, "Audited: 2 versions in pins.txt, 0 with known vulnerabilities\n"),
        ([CLEAN, VULNERABLE], 1, "pillow 11.3.0 has CVE-2026-25990, fixed in 12.1.1\n"),
        ([CLEAN, SKIPPED], 3, "NOT AUDITED: 1 of the 2 versions in pins.txt. The first reason: not on PyPI\n"),
        ([CLEAN], 3, "NOT AUDITED: 1 of the 2 versions in pins.txt. The first reason: no network\n"),
        (None, 3, "NOT AUDITED: 2 of the 2 versions in pins.txt. The first reason: no network\n"),
    ],
)
def test_the_audit_fails_on_vulnerable_and_on_unaudited_versions(
    tmp_path: Path, monkeypatch, capsys, found: list[dict] | None, status: int, told: str
) -> None:
    output = "" if found is None else json.dumps({"dependencies": found})
    ended = subprocess.CompletedProcess([], 0, output, "no network\n")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: ended)
    pins = tmp_path / "pins.txt"
    pins.write_text('# versions\nnumpy==2.4.6; python_version >= "3.11"\npillow==11.3.0\n', encoding="utf-8")
    assert CI["main"](pins) == status
    assert told in capsys.readouterr().out
