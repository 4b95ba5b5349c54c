#!/usr/bin/env python3
"""That commits.py sees what it is there for, on messages and on a made history."""
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import commits

GOOD = "Hold the knee while the hip moves\n\nThe hip's torque reached the knee through the frame.\n"
BAD = {
    "Hold the knee": "no body",
    "Hold the knee\nbecause": "second line",
    "hold the knee\n\nwhy": "capital",
    "Hold the knee.\n\nwhy": "full stop",
    "Holding the knee\n\nwhy": "not with an imperative",
    "Holds the knee\n\nwhy": "not with an imperative",
    "Added a knee\n\nwhy": "not with an imperative",
    "Hold " + "the knee " * 8 + "\n\nwhy": "columns",
    "Hold the knee\n\n" + "w" * 101: "body line",
}


def git(folder, *words):
    name = ["-c", "user.name=t", "-c", "user.email=t@t", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", "-C", folder, *name, *words], check=True, capture_output=True)


def history(messages):
    """Exit status of the program on a repository with these commits after a first one."""
    with tempfile.TemporaryDirectory() as folder:
        git(folder, "init", "-q")
        git(folder, "commit", "-q", "--allow-empty", "-m", "first")
        for message in messages:
            git(folder, "commit", "-q", "--allow-empty", "-m", message)
        script = pathlib.Path(__file__).with_name("commits.py")
        return subprocess.run([sys.executable, script, folder, f"HEAD~{len(messages)}..HEAD"],
                              capture_output=True).returncode


assert not list(commits.deviations(GOOD)), list(commits.deviations(GOOD))
for subject in ("Pass the bus", "Bring a hand", "Need no heap", "Address the bus", "Embed the page", "Bias the gyro"):
    assert not list(commits.deviations(subject + "\n\nwhy")), subject
for message, word in BAD.items():
    found = list(commits.deviations(message))
    assert any(word in complaint for complaint in found), (message, found)
assert history([GOOD, GOOD]) == 0
assert history([GOOD, "Holds a knee", GOOD]) == 1
with tempfile.TemporaryDirectory() as nowhere:
    script = pathlib.Path(__file__).with_name("commits.py")
    assert subprocess.run([sys.executable, script, nowhere], capture_output=True).returncode == 77
print("commits.py: holds")
