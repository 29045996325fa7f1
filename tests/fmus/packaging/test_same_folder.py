"""Two at the same time in one folder: what each leaves is whole."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

WRITER = """
import sys
from pathlib import Path
from fmus.packaging.archive import write_files
print("ready", flush=True)
for k in range(60):
    write_files({"a": sys.argv[2].encode() * 200_000, "b": b"end"}, Path(sys.argv[1]))
"""


def test_two_builds_of_one_file_leave_a_whole_one(tmp_path: Path) -> None:
    """Two processes write different archives to one name, again and again; whoever reads it finds one of the two."""
    target = tmp_path / "wheel.fmu"
    command = [sys.executable, "-c", WRITER, str(target)]
    writers = [subprocess.Popen([*command, text], stdout=subprocess.PIPE, text=True) for text in "xy"]
    for writer in writers:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "ready\n"
    seen = 0
    while any(writer.poll() is None for writer in writers) or not seen:
        if target.exists():
            with zipfile.ZipFile(target) as archive:
                assert archive.read("b") == b"end"
                assert set(archive.read("a")) in ({ord("x")}, {ord("y")})
            seen += 1
    for writer in writers:
        writer.communicate()
        assert writer.returncode == 0
    assert [path.name for path in tmp_path.iterdir()] == ["wheel.fmu"]
