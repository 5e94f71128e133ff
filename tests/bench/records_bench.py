#!/usr/bin/python3
"""Records to transfer functions, struna beside numpy and scipy in one run, one thread each; processor times.

usage: records_bench.py RECORDS_BENCH [ROWS]      (the built benchmark program; 3000000 rows)

Prints rows `method,knob,value,error,time`: for the transfer functions the error is the largest relative difference
from scipy's, lines below 10 Hz left out (there the two treat the mean differently). The last lines are the ratios.
"""
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy import signal

RESOLUTION_HZ = 0.25
SAMPLE_RATE_HZ = 25600.0


def median_time(work, runs=3):
    times = []
    for _ in range(runs):
        start = time.process_time()
        result = work()
        times.append(time.process_time() - start)
    return sorted(times)[runs // 2], result


def scipy_transfer(data):
    segment = dict(fs=SAMPLE_RATE_HZ, window="hann", nperseg=int(SAMPLE_RATE_HZ / RESOLUTION_HZ), detrend="constant")
    _, s_xx = signal.welch(data[:, 1], **segment)
    functions, coherences = [], []
    for k in range(2, 5):
        frequency, s_xy = signal.csd(data[:, 1], data[:, k], **segment)
        _, s_yy = signal.welch(data[:, k], **segment)
        functions.append(s_xy / s_xx)
        coherences.append(abs(s_xy) ** 2 / (s_xx * s_yy))
    return frequency, functions, coherences


def bench(program, *words):
    lines = subprocess.run([program, *map(str, words)], check=True, capture_output=True, text=True).stdout.split("\n")
    return [line.split(",") for line in lines if line]


def main():
    program = sys.argv[1]
    rows = int(sys.argv[2]) if len(sys.argv) > 2 else 3_000_000
    with tempfile.TemporaryDirectory() as folder:
        four, five, out = (os.path.join(folder, name) for name in ("four.csv", "five.csv", "trfam.csv"))
        bench(program, "generate", four, rows, 3)
        bench(program, "generate", five, rows, 4)
        print("method,knob,value,error,time [s]")
        reading = bench(program, "read", four)
        for row in reading:
            print(",".join(row))
        load_time, data = median_time(lambda: np.loadtxt(five, delimiter=",", skiprows=1))
        print(f"numpy.loadtxt,columns,5,0,{load_time:.4f}")
        scipy_time, (frequency, functions, coherences) = median_time(lambda: scipy_transfer(data))
        print(f"scipy.signal 3 csd + 4 welch,resolution [Hz],{RESOLUTION_HZ},0,{scipy_time:.4f}")
        row = bench(program, "transfer", five, RESOLUTION_HZ, out)[0]
        ours = np.loadtxt(out, delimiter=",", skiprows=1)
        lines = np.searchsorted(frequency, ours[:, 0] - 1e-6)
        used = ours[:, 0] >= 10.0
        error = 0.0
        for k in range(3):
            ours_k = ours[used, 1 + 4 * k] + 1j * ours[used, 2 + 4 * k]
            theirs_k = functions[k][lines][used]
            error = max(error, np.max(abs(ours_k - theirs_k) / abs(theirs_k)))
        row[3] = f"{error:.1e}"
        print(",".join(row))
        print(f"reading: {float(reading[1][4]) / float(reading[0][4]):.2f} times fast-cpp-csv-parser alone")
        print(f"read + 3 transfer functions: {(load_time + scipy_time) / float(row[4]):.2f} times faster than numpy + scipy")


main()
