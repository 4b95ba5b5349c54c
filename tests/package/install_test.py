#!/usr/bin/env python3
"""Installs the controller's package in a fresh Debian 12, starts it on the emulated robot, stops it, removes and
purges it: the key is private, the robot becomes idle, and nothing is left.

Usage: install_test.py SANSO_FIRMWARE.deb SANSO_EMULATOR WORK-FOLDER
Exit codes: 0 as expected, 1 not, 77 skipped: needs root, mmdebstrap, mount rights and a Debian mirror.
"""
import os
import pathlib
import re
import shutil
import signal
import socket
import stat
import subprocess
import sys
import time

DEPENDS = "adduser,libsodium23,libusb-1.0-0,libhidapi-libusb0,libyaml-0-2,libzstd1,libstdc++6"
# What dpkg itself and the tools of the user database write; nothing of ours.
NOT_OURS = re.compile(r"^(var/lib/dpkg/|var/log/|var/cache/|etc/(passwd|group|shadow|gshadow|subuid|subgid)-?$"
                      r"|etc/\.pwd\.lock$|proc/|sys/|dev/|run/|tmp/)")


def skip(why):
    print(f"SKIPPED: the package was NOT installed and removed: {why}")
    sys.exit(77)


def expect(condition, message):
    if not condition:
        print(f"FAILED: {message}")
        sys.exit(1)


def run(*command, check=True, **options):
    done = subprocess.run(command, text=True, capture_output=True, **options)
    if check and done.returncode != 0:
        print(done.stdout, done.stderr)
        expect(False, f"{' '.join(command)} ended with {done.returncode}")
    return done


def fresh_root(root, cache):
    """An unpacked minimal Debian; made once, kept as an archive."""
    if not cache.exists():
        made = run("mmdebstrap", "--variant=minbase", f"--include={DEPENDS}", "bookworm", str(cache) + ".new.tar",
                   check=False)
        if made.returncode != 0:
            skip("mmdebstrap could not make a Debian 12: " + made.stderr.strip().splitlines()[-1])
        os.rename(str(cache) + ".new.tar", cache)
    root.mkdir(parents=True)
    run("tar", "-xf", str(cache), "-C", str(root))


def inventory(root):
    """Every path with type, mode and owner, and the users and groups there are."""
    found = {}
    for folder, folders, files in os.walk(root):
        for name in folders + files:
            path = os.path.join(folder, name)
            short = os.path.relpath(path, root)
            if not NOT_OURS.match(short + ("/" if name in folders else "")) and not NOT_OURS.match(short):
                status = os.lstat(path)
                found[short] = (stat.filemode(status.st_mode), status.st_uid, status.st_gid)
    for base in ("passwd", "group"):
        found[f"lines of etc/{base}"] = sorted((root / "etc" / base).read_text().splitlines())
    return found


class Mounts:
    """The pseudo-terminals of this machine inside the new one: the emulated servo bus is one of them."""

    def __init__(self, root):
        self.path = root / "dev" / "pts"

    def __enter__(self):
        self.path.mkdir(parents=True, exist_ok=True)
        if run("mount", "--bind", "/dev/pts", str(self.path), check=False).returncode != 0:
            skip("mount is not allowed here")

    def __exit__(self, *_):
        run("umount", "--lazy", str(self.path), check=False)


def remove(root):
    """Never through a mount: what is mounted there belongs to this machine."""
    if root.exists():
        mounts = pathlib.Path("/proc/mounts").read_text()
        expect(str(root) not in mounts, f"something is still mounted below {root}; umount it first")
        shutil.rmtree(root)


def wait_for(condition, seconds, what):
    end = time.monotonic() + seconds
    while not condition():
        expect(time.monotonic() < end, f"{what}: not within {seconds} s")
        time.sleep(0.05)


class Manager:
    """What systemd would hear."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(str(path))
        os.chmod(path, 0o777)
        self.socket.setblocking(False)
        self.lines = []

    def heard(self, line):
        try:
            while True:
                self.lines.append(self.socket.recv(4096).decode())
        except BlockingIOError:
            return line in self.lines


def start_on_the_emulator(root, emulator):
    """The installed program as its own user, in the new system, with the settings of the package."""
    robot = root / "tmp" / "robot"
    robot.mkdir()
    emulated = subprocess.Popen([emulator, "--dir", str(robot)], stdout=subprocess.DEVNULL)
    try:
        wait_for(lambda: all((robot / name).exists() for name in ("bus", "imu")), 20, "the emulator's devices")
        bus = os.readlink(robot / "bus")
        os.chmod(bus, 0o666)
        os.chmod(robot, 0o755)
        for name in ("imu", "pose"):
            os.chmod(robot / name, 0o777)
        settings = (root / "etc" / "sanso" / "robot.toml").read_text()
        settings = re.sub(r'(?m)^bus = .*$', f'bus = "{bus}"', settings)
        settings = re.sub(r'(?m)^imu = .*$', 'imu = "unix:/tmp/robot/imu"', settings)
        settings += 'listen = "127.0.0.1"\nport = 0\nallow_without_realtime = true\n'
        (root / "tmp" / "robot.toml").write_text(settings)
        run("chroot", str(root), "install", "-d", "-o", "sanso", "-m", "750", "/var/log/sanso")  # LogsDirectory=
        manager = Manager(root / "tmp" / "notify")
        program = subprocess.Popen(
            ["chroot", "--userspec=sanso:sanso", "--groups=dialout", str(root), "/usr/bin/sanso-firmware",
             "--config", "/tmp/robot.toml"],
            env={"NOTIFY_SOCKET": "/tmp/notify", "WATCHDOG_USEC": "2000000", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"})
        try:
            wait_for(lambda: manager.heard("READY=1"), 20, "ready")
            wait_for(lambda: manager.heard("STATUS=idle"), 60, "idle")
            expect(manager.lines.count("WATCHDOG=1") > 2, "the watchdog is fed")
            program.send_signal(signal.SIGTERM)
            expect(program.wait(timeout=40) == 0, "SIGTERM ends the program with 0")
            expect(manager.heard("STOPPING=1"), "it says that it stops")
        finally:
            program.kill()
            program.wait()
    finally:
        emulated.terminate()
        emulated.wait()
    logs = list((root / "var" / "log" / "sanso").glob("*.mcap"))
    expect(len(logs) == 1 and logs[0].stat().st_size > 10_000, f"one log of ticks: {logs}")
    print(f"idle, {manager.lines.count('WATCHDOG=1')} times watchdog, log of {logs[0].stat().st_size} bytes")


def main():
    package, emulator, work = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    for tool in ("mmdebstrap", "chroot", "dpkg-deb"):
        if shutil.which(tool) is None:
            skip(f"no {tool}")
    if os.geteuid() != 0:
        skip("needs root")
    root = work / "root"
    remove(root)
    work.mkdir(parents=True, exist_ok=True)
    fresh_root(root, work / "debian.tar")
    before = inventory(root)
    shutil.copy(package, root / "tmp" / "sanso.deb")
    with Mounts(root):
        run("chroot", str(root), "dpkg", "-i", "/tmp/sanso.deb")
        key = root / "etc" / "sanso" / "robot.key"
        status = key.stat()
        expect(stat.S_IMODE(status.st_mode) == 0o600, f"the key has mode 0600, not {oct(status.st_mode)}")
        expect(re.fullmatch("[0-9a-f]{64}", key.read_text()), "the key is 64 hexadecimal digits")
        owner = run("chroot", str(root), "stat", "-c", "%U", "/etc/sanso/robot.key").stdout.strip()
        expect(owner == "sanso", f"the key belongs to sanso, not {owner}")
        digits = key.read_text()
        start_on_the_emulator(root, str(emulator))
        run("chroot", str(root), "dpkg", "-i", "/tmp/sanso.deb")
        expect(key.read_text() == digits, "installing again keeps the key")
        run("chroot", str(root), "dpkg", "-r", "sanso-firmware")
        expect(key.exists() and (root / "etc/sanso/robot.toml").exists(), "removing keeps key and settings")
        expect(not (root / "usr/bin/sanso-firmware").exists(), "removing takes the program")
        run("chroot", str(root), "dpkg", "-P", "sanso-firmware")
    after = inventory(root)
    left = sorted(set(after) - set(before)) + sorted(k for k in before if after.get(k) != before[k])
    expect(not left, "purging leaves: " + ", ".join(f"{k}: {before.get(k)} -> {after.get(k)}" for k in left[:20]))
    expect(not (root / "var/log/sanso").exists(), "purging takes the log")
    remove(root)
    print(f"{package.name}: installed, idle, removed; {len(before)} paths as before")


if __name__ == "__main__":
    main()
