#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Random scenes, most of them odd, through the real programs: does every answer keep its bound?

    tests/load/random_scenes.py BUILD_DIR [SEED] [COUNT]

Each scene is served by a device drawn by lot; points far out, at times from years back to decades
ahead, are answered by the server, by a client from streamed tiles and by the direct sum. An answer
further from the sum than both bounds is a miss unless it is flagged folded or not converged. The
scene of a miss is kept in the working folder. Exit code 1 if there was any.
"""
import json
import math
import pathlib
import random
import subprocess
import sys

POINTS = 30
FOLDED_OR_NOT_CONVERGED = 3


class Draw(random.Random):
    def log_uniform(self, low, high):
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def system(self):
        """TOML of one wave system, and about its longest wave, m."""
        turn = f"from_deg = {self.uniform(0, 359):.1f}\n"
        if self.random() < 0.6:
            wind = self.log_uniform(0.5, 70)
            spectrum = self.choice(["jonswap", "tma", "pierson_moskowitz", "phillips"])
            spreading = self.choice(["cos2", "cos2s", "mitsuyasu", "hasselmann", "donelan_banner"])
            return (f'[[sea.system]]\ntype = "wind"\nspectrum = "{spectrum}"\n{turn}'
                    f'wind_speed_10m_mps = {wind:.3g}\nspreading = "{spreading}"\n', 0.8 * wind**2)
        period = self.log_uniform(1, 25)
        return (f'[[sea.system]]\ntype = "swell"\nspectrum = "jonswap"\n{turn}'
                f"significant_height_m = {self.log_uniform(1e-4, 12):.3g}\n"
                f'peak_period_s = {period:.3g}\nspreading = "cos2s"\n'
                f"spreading_exponent = {self.log_uniform(1, 1e6):.3g}\n", 1.56 * period**2)

    def scene(self):
        depth = self.choice(["inf", f"{self.log_uniform(0.3, 5000):.3g}"])
        systems = [self.system() for _ in range(self.choice([0, 1, 1, 2, 3]))]
        length_m = max([5.0] + [longest * self.uniform(2, 12) for _, longest in systems])
        text = (f"[sea]\nseed = {self.randrange(2**31)}\ndepth_m = {depth}\n"
                f"choppiness = {self.choice([0, 0.5, 1, 1.5, 3])}\n"
                f"loop_period_s = {self.choice([0, 0, 0, 10, 3600])}\n"
                f"gravity_mps2 = {self.choice([9.81, 9.81, 1.62, 24.8])}\n")
        text += "".join(part for part, _ in systems)
        for _ in range(self.choice([1, 2, 3, 4])):
            text += (f"[[cascade]]\nlength_m = {length_m:.4g}\n"
                     f"size = {self.choice([64, 128, 256])}\n")
            length_m /= self.uniform(3, 9)
            if length_m < 0.1:
                break
        return text + (f"[foam]\nthreshold = {self.uniform(-1, 1):.2f}\n"
                       f"decay_s = {self.choice([0, 0.1, 4, 1000])}\n"
                       f"[accuracy]\nheight_error_m = {self.choice([0.002, 0.01, 0.1])}\n")


def ask(program, url, points, time_s, *how):
    done = subprocess.run([program, url, *points, "--time", str(time_s), "--format", "json", *how],
                          capture_output=True, text=True, timeout=120, check=True)
    return json.loads(done.stdout)


def misses(draw, bin_dir, url):
    """Lines about answers that broke their bound."""
    points = []
    for _ in range(POINTS):
        points += ["--at", f"{draw.uniform(-1e5, 1e5):.2f},{draw.uniform(-1e5, 1e5):.2f}"]
    time_s = draw.choice([0, 0.37, 1e5, 1e9, -5e7])
    program = bin_dir / "seaway-query"
    exact = ask(program, url, points, time_s, "--exact")
    found = []
    for how in ([], ["--local"]):
        for answer, truth in zip(ask(program, url, points, time_s, *how), exact, strict=True):
            apart = abs(answer["height_m"] - truth["height_m"])
            if not apart <= answer["error_m"] + truth["error_m"] and not (
                    int(answer["flags"]) & FOLDED_OR_NOT_CONVERGED):
                found.append(f"{' '.join(how) or 'server'}: {apart:.3g} m apart, stated "
                             f"{answer['error_m']:.3g} m, at t = {time_s} s")
    return found


def run(draw, bin_dir, path):
    """What went wrong with one scene, and whether the server took it."""
    device = draw.choice(["auto", "native"])
    server = subprocess.Popen([bin_dir / "seaway-server", path, "--listen", "127.0.0.1:0",
                               "--device", device], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
    try:
        ready = server.stdout.readline()
        if not ready.startswith("ready "):
            code = server.wait(30)
            return ([] if code == 2 else [f"exit code {code}"]), False
        found = misses(draw, bin_dir, ready.split()[1])
    except (subprocess.SubprocessError, ValueError, KeyError) as problem:
        found = [repr(problem)]
    finally:
        server.terminate()
        code = server.wait(10)
    return [f"{device}: {line}" for line in found] + ([f"exit code {code}"] if code else []), True


def main(arguments):
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    bin_dir = pathlib.Path(arguments[0]).resolve() / "bin"
    seed = int(arguments[1]) if len(arguments) > 1 else 1
    count = int(arguments[2]) if len(arguments) > 2 else 100
    draw = Draw(seed)
    bad = refused = 0
    for i in range(count):
        path = pathlib.Path(f"random_scene_{seed}_{i}.toml")
        path.write_text(draw.scene(), encoding="utf-8")
        found, taken = run(draw, bin_dir, path)
        refused += not taken
        bad += bool(found)
        for line in found:
            print(f"{path}: {line}", flush=True)
        if not found:
            path.unlink()
    print(f"{count} scenes, {refused} refused, {bad} with misses")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
