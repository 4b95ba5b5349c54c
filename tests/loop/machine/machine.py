#!/usr/bin/env python3
"""Tier 2: the controller's program on Debian's PREEMPT_RT kernel in QEMU, in virtual time.

The kernel's own drivers (ftdi_sio, usbhid, hidraw) and libusb and hidapi stand between sanso-firmware and sanso-emulator --usb,
which plugs the servo bus as an FTDI chip and the IMU as a HID device into the kernel's virtual host controller. Virtual time:
one instruction is 2 ns, waiting costs nothing, so the same image gives the same figures on any machine, loaded or not. They
compare back ends and find defects; they say nothing about the latency of a real board.

usage: machine.py BINARIES KERNEL [--page FILE] [--json] [--seconds N] [--skip-code N]
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = ["vhci-hcd", "ftdi_sio", "usbhid", "hid-generic"]
NEEDED = {"qemu-system-x86_64": "qemu-system-x86", "busybox": "busybox-static"}

# which way to the bus and to the IMU
BACK_ENDS = {
    "tty_hidraw": ("/dev/ttyUSB0", "hidraw:1209:5a50", "tty driver", "hidraw"),
    "libusb_hidapi_libusb": ("ftdi:0403:6014", "hidapi-libusb:1209:5a50", "libusb", "hidapi over libusb"),
    "tty_hidapi_libusb": ("/dev/ttyUSB0", "hidapi-libusb:1209:5a50", "tty driver", "hidapi over libusb"),
    "libusb_hidraw": ("ftdi:0403:6014", "hidraw:1209:5a50", "libusb", "hidraw"),
}

INIT = """#!/bin/sh
export PATH=/bin:/sbin HOME=/
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev
mkdir -p /dev/pts /dev/shm /tmp /run; mount -t tmpfs tmp /tmp
while read -r m; do insmod /modules/$m || echo "FAILED insmod $m"; done < /modules/order
ifconfig lo 127.0.0.1 up
echo -1 > /proc/sys/kernel/sched_rt_runtime_us
sh /guest.sh
poweroff -f
"""


def module_files(kernel):
    """The modules and all that they depend on, in the order in which they are loaded."""
    by_name = {}
    for folder, _, files in os.walk(os.path.join(kernel, "modules")):
        for f in files:
            if f.endswith(".ko"):
                by_name[f[:-3].replace("-", "_")] = os.path.join(folder, f)
    order = []

    def add(name):
        path = by_name.get(name.replace("-", "_"))
        if path is None or path in order:
            return  # built in, or there
        depends = re.search(rb"\0depends=([^\0]*)\0", open(path, "rb").read())
        for other in (depends.group(1).decode().split(",") if depends else []):
            if other:
                add(other)
        order.append(path)

    for name in MODULES:
        add(name)
    return order


class Initramfs:
    """An archive in the format "newc", as the kernel unpacks it."""

    def __init__(self):
        self.out, self.inode, self.folders = bytearray(), 1, set()

    def entry(self, name, mode, data=b""):
        head = [self.inode, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(name) + 1, 0]
        self.inode += 1
        self.out += b"070701" + "".join("%08X" % v for v in head).encode() + name.encode() + b"\0"
        self.out += b"\0" * (-len(self.out) % 4) + data
        self.out += b"\0" * (-len(self.out) % 4)

    def folder(self, name):
        if name and name not in self.folders:
            self.folder(os.path.dirname(name))
            self.folders.add(name)
            self.entry(name, 0o040755)

    def file(self, name, data, mode=0o755):
        self.folder(os.path.dirname(name))
        self.entry(name, 0o100000 | mode, data)

    def link(self, name, target):
        self.folder(os.path.dirname(name))
        self.entry(name, 0o120777, target.encode())

    def program(self, path):
        """With the shared libraries that the loader finds for it."""
        self.file("bin/" + os.path.basename(path), open(path, "rb").read())
        self.libraries(path)

    def libraries(self, path):
        text = subprocess.run(["ldd", path], capture_output=True, text=True).stdout
        for library in re.findall(r"(/\S+\.so\S*)", text):
            name = library.lstrip("/")
            if name not in self.folders:
                self.folders.add(name)
                self.file(name, open(library, "rb").read())

    def done(self):
        self.entry("TRAILER!!!", 0)
        return bytes(self.out)


def configuration(bus, imu):
    return f"""[device]
bus = "{bus}"
imu = "{imu}"
listen = "127.0.0.1"
port = 7531
key_file = "/etc/sanso/robot.key"
log_directory = "/tmp/log"
log_keep_MB = 0
""".encode()


def image(binaries, kernel, runs):
    fs = Initramfs()
    for name in ("proc", "sys", "dev", "tmp", "run", "sbin", "etc/sanso"):
        fs.folder(name)
    busybox = shutil.which("busybox")
    fs.file("bin/busybox", open(busybox, "rb").read())
    for applet in subprocess.run([busybox, "--list"], capture_output=True, text=True).stdout.split():
        if applet != "busybox":
            fs.link("bin/" + applet, "busybox")
    order = module_files(kernel)
    for path in order:
        fs.file("modules/" + os.path.basename(path), open(path, "rb").read(), 0o644)
    fs.file("modules/order", "".join(os.path.basename(p) + "\n" for p in order).encode(), 0o644)
    fs.program(os.path.join(binaries, "firmware", "sanso-firmware"))
    fs.program(os.path.join(binaries, "tools", "emulator", "sanso-emulator"))
    # hidapi's back end is loaded by name, when a setting asks for it
    for library in ("libhidapi-libusb.so.0", "libhidapi-hidraw.so.0"):
        for folder in ("/usr/lib/x86_64-linux-gnu", "/lib/x86_64-linux-gnu"):
            path = os.path.join(folder, library)
            if os.path.exists(path):
                if path.lstrip("/") not in fs.folders:
                    fs.folders.add(path.lstrip("/"))
                    fs.file(path.lstrip("/"), open(path, "rb").read())
                    fs.libraries(path)
                break
    for name, (bus, imu, _, _) in BACK_ENDS.items():
        fs.file(f"etc/sanso/{name}.toml", configuration(bus, imu), 0o644)
    fs.file("etc/sanso/robot.key", b"0123456789abcdef" * 4 + b"\n", 0o600)
    fs.file("etc/sanso/runs", "".join(r + "\n" for r in runs).encode(), 0o644)
    fs.file("guest.sh", open(os.path.join(HERE, "guest.sh"), "rb").read())
    fs.file("init", INIT.encode())
    return fs.done()


def boot(binaries, kernel, runs, limit_s):
    with tempfile.TemporaryDirectory() as folder:
        initrd, log = os.path.join(folder, "initrd"), os.path.join(folder, "log")
        with open(initrd, "wb") as out:
            out.write(image(binaries, kernel, runs))
        command = ["qemu-system-x86_64", "-accel", "tcg,thread=single", "-icount", "shift=1,sleep=off",
                   "-rtc", "base=2026-01-01T00:00:00,clock=vm", "-cpu", "max,-rdrand,-rdseed", "-smp", "1", "-m", "512",
                   "-M", "q35", "-nodefaults", "-no-reboot", "-display", "none", "-serial", "file:" + log,
                   "-kernel", os.path.join(kernel, "vmlinux"), "-initrd", initrd,
                   "-append", "console=ttyS0 quiet panic=-1 nokaslr norandmaps rdinit=/init"]
        try:
            subprocess.run(command, timeout=limit_s, check=False)
        except subprocess.TimeoutExpired:
            pass
        return open(log, errors="replace").read().replace("\r", "") if os.path.exists(log) else ""


def parse(log):
    """By run: exit code, what the program said, the histograms."""
    runs = {}
    for name, body in re.findall(r"^RUN (\S+)\n(.*?)^OVER$", log, re.S | re.M):
        code = re.search(r"^END (\d+)$", body, re.M)
        said, _, table = body.partition("TIMES\n")
        rows = [line.split(",") for line in table.strip().splitlines()]
        times = {}
        if rows:
            edges = [float(row[0]) for row in rows[1:]]
            for column, title in enumerate(rows[0][1:], start=1):
                times[title] = {"less_than_us": edges, "count": [int(row[column]) for row in rows[1:]]}
        runs[name] = {"code": int(code.group(1)) if code else None, "said": said, "times": times}
    return runs


def broken(runs, wanted):
    """What is not as it should be: events only, no durations."""
    out = []
    for name in wanted:
        run = runs.get(name)
        if run is None:
            out.append(f"{name}: did not end")
            continue
        faults = re.findall(r"sanso-firmware: (F\d+ \w+)", run["said"])
        if run["code"] != 0:
            out.append(f"{name}: ended with {run['code']}")
        if " idle" not in run["said"]:
            out.append(f"{name}: never idle")
        if name.startswith("replug"):
            if not any(f.startswith("F12") for f in faults):
                out.append(f"{name}: no F12 when the cable was out")
            if run["said"].count(": gone") < 2 or run["said"].count(": open") < 4:
                out.append(f"{name}: the bus did not come back twice")
        elif faults:
            out.append(f"{name}: {faults}")
        if not name.startswith("replug") and sum(run["times"].get("reply", {"count": []})["count"]) < 100:
            out.append(f"{name}: fewer than 100 ticks with replies")
    return out


def quantile(histogram, share):
    total, seen = sum(histogram["count"]), 0
    for edge, count in zip(histogram["less_than_us"], histogram["count"]):
        seen += count
        if total and seen >= share * total:
            return edge
    return 0.0


def figures(runs):
    return {name: {title: {"count": sum(h["count"]), "p50": quantile(h, 0.5), "p99": quantile(h, 0.99),
                           "p99.9": quantile(h, 0.999), "longest": quantile(h, 1.0)}
                   for title, h in run["times"].items()} for name, run in runs.items()}


def page(runs, kernel, seconds):
    lines = ["# Tier 2: a real-time kernel in virtual time", "",
             "Made by `tools/test --tier 2 --page docs/results/machine.md`. The program `sanso-firmware` on Debian's kernel",
             f"{kernel} (PREEMPT_RT) in QEMU, one processor, one instruction in 2 ns. The emulator is in the same machine and",
             "plugs bus (FT232H, 2 Mbit/s, latency timer 1 ms) and IMU (HID, a report each millisecond) into `vhci_hcd`; above",
             "them are the kernel's own `ftdi_sio`, `usbserial`, `usbhid`, `hidraw`, and libusb and hidapi.", "",
             "**Virtual time counts instructions.** It is the same on every machine and under every load of it, and it shows",
             "what waits for what: priorities, work queues, time-outs. It knows no caches, no memory, no bus of a real board and",
             "no USB controller, and the emulator's own instructions run on the same processor. No figure here is a latency of",
             "a robot; `sanso-firmware` prints the same ones when it ends, there they are.", "",
             f"Each run: {seconds} s idle or loaded (a busy loop, a writer of 64 kB blocks, a reader of /sys, all at ordinary",
             "priority). The controller is in `idle` and reads all 20 servos in every tick. Bins are a quarter of an octave wide:",
             "figures are their upper ends, in microseconds. *Wake-up* is how late the tick began, *tick* its wall time, *reply*",
             "from request to the last servo's reply, *IMU age* that of the sample in use.", "",
             "| bus | IMU | load | ticks | wake-up p50 | p99 | longest | tick p50 | p99 | longest | reply p50 | p99 | p99.9 | longest "
             "| IMU age p50 | p99 | longest |", "|" + "---|" * 17]
    for name, found in figures(runs).items():
        if not runs[name]["times"]:
            continue
        back_end, _, load = name.rpartition("_")
        bus, imu = BACK_ENDS[back_end][2:]
        cells = [bus, imu, load, str(found["tick"]["count"])]
        for title, keys in (("wake", ("p50", "p99", "longest")), ("tick", ("p50", "p99", "longest")),
                            ("reply", ("p50", "p99", "p99.9", "longest")), ("imu_age", ("p50", "p99", "longest"))):
            cells += ["%.0f" % found[title][key] for key in keys]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "## Histograms", "", "Ticks by upper end of the bin, microseconds; empty bins left out.", ""]
    for title, words in (("wake", "Wake-up"), ("tick", "Tick"), ("reply", "Reply"), ("imu_age", "IMU age")):
        names = [n for n in runs if runs[n]["times"]]
        lines += [f"### {words}", "", "| less than | " + " | ".join(n.replace("_", " ") for n in names) + " |",
                  "|" + "---|" * (len(names) + 1)]
        edges = runs[names[0]]["times"][title]["less_than_us"]
        for k, edge in enumerate(edges):
            counts = [runs[n]["times"][title]["count"][k] for n in names]
            if any(counts):
                lines.append(f"| {edge:g} | " + " | ".join(str(c) for c in counts) + " |")
        lines.append("")
    return "\n".join(lines)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("binaries")
    options.add_argument("kernel")
    options.add_argument("--page")
    options.add_argument("--json", action="store_true")
    options.add_argument("--seconds", type=float, default=2.0, help="of each run")
    options.add_argument("--all", action="store_true", help="the mixed pairs of back ends too")
    options.add_argument("--log", help="what the machine printed")
    options.add_argument("--limit-s", type=float, default=600.0)
    o = options.parse_args()
    missing = [package for program, package in NEEDED.items() if shutil.which(program) is None]
    if missing or not os.path.exists(os.path.join(o.kernel, "vmlinux")):
        print("SKIPPED: no virtual machine: " + (", ".join(missing) if missing else o.kernel + " has no kernel (tools/rt-kernel)"))
        return 77
    names = list(BACK_ENDS) if o.all else list(BACK_ENDS)[:2]
    runs = [f"run {n}_{load} {n} {load} {o.seconds:g}" for n in names for load in ("idle", "loaded")]
    runs.append("replug replug_libusb libusb_hidapi_libusb")
    began = time.monotonic()
    log = boot(o.binaries, o.kernel, runs, o.limit_s)
    if o.log:
        open(o.log, "w").write(log)
    kernel = re.search(r"^KERNEL (\S+) realtime (\d)", log, re.M)
    found = parse(log)
    wrong = broken(found, [r.split()[1] for r in runs])
    if not kernel or kernel.group(2) != "1":
        wrong.append("no PREEMPT_RT kernel came up")
    if o.page and not wrong:
        open(o.page, "w").write(page(found, kernel.group(1), f"{o.seconds:g}"))
    if o.json:
        print(json.dumps(figures(found), indent=1))
    for what in wrong:
        print("NOT AS EXPECTED: " + what)
    if wrong:
        print(log[-6000:])
    print(f"{len(runs)} runs in {time.monotonic() - began:.0f} s, {len(wrong)} defects")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
