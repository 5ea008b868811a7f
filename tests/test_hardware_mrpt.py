"""MRPT's rawlog-grabber (Debian: mrpt-apps) reads the emulated lidar: 15 s, asked for with HOPSLAM_MRPT=1."""

import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from hardware.emulator.emulator import Emulator
from sim.plant import plan_plant
from slam.scenario.file import load_scenario

pytestmark = pytest.mark.skipif(
    not (os.environ.get("HOPSLAM_MRPT") and shutil.which("rawlog-grabber")),
    reason="opt-in: apt-get install mrpt-apps, and set HOPSLAM_MRPT=1",
)

SETTINGS = """
[global]
rawlog_prefix = {folder}/out
time_between_launches = 300
use_sensoryframes = 0
GRABBER_PERIOD_MS = 500
rawlog_GZ_compress_level = 0

[LASER]
driver = CHokuyoURG
process_rate = 90
sensorLabel = HOKUYO
pose_x = 0
pose_y = 0
pose_z = 0
pose_yaw = 0
pose_pitch = 0
pose_roll = 0
COM_port_LIN = {port}
COM_baudRate = 115200
HOKUYO_HS_mode = false
reduced_fov = 0
"""


def test_mrpt_reads_ten_full_scans_a_second(tmp_path: Path) -> None:
    with Emulator(plan_plant(load_scenario("corridor"))) as emulator:
        settings = tmp_path / "grabber.ini"
        settings.write_text(SETTINGS.format(folder=tmp_path, port=emulator.lidar.port.address))
        words = ["rawlog-grabber", str(settings)]
        with subprocess.Popen(words, cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL) as grabber:
            time.sleep(12.0)
            grabber.communicate(b"\n")  # any key ends it
    (rawlog,) = tmp_path.glob("*.rawlog")
    printed = subprocess.run(["rawlog-edit", "--info", "-i", rawlog], capture_output=True, text=True, check=False)
    found = re.search(r"HOKUYO */ *(\d+) */ *([\d.]+)", printed.stdout + printed.stderr)
    assert found is not None, printed.stdout + printed.stderr
    count, rate = int(found[1]), float(found[2])
    assert count > 50
    assert rate == pytest.approx(10.0, abs=0.2)
    assert rawlog.stat().st_size / count > 682 * 5  # a float and a flag for each range
