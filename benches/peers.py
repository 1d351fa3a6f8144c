"""Error against run time beside Mitsuba 3, Cycles and LuxCore: one page over the scenes of a folder of peers.

  python benches/peers.py PEERS --out DIR [--scenes a,b] [--spp 1,4,16,64,256] [--res 128] [--ref-spp 8192] [--octray PATH]

PEERS holds the scripts that set the other renderers up and run them (`scenes.py`, `error_time.py`); it is no part of this
repository. Run it with the Python that they installed, on an otherwise idle machine, pinned to one core:

  taskset -c 0 $PEERS_DIR/venv/bin/python benches/peers.py ../shared/peers --out peers-report

The other renderers' images and CPU seconds, one thread, are taken from `error_time.py`, and so is the reference: Mitsuba's,
from eight seeds, with its variance. `octray converge --against` measures all of them alike and draws the page.
"""
import argparse, csv, json, os, subprocess, sys

ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
ap.add_argument("peers")
ap.add_argument("--out", required=True)
ap.add_argument("--scenes", default="cornell,small_large_lights,veach_mis,many_lights")
ap.add_argument("--renderers", default="mitsuba-llvm,mitsuba-llvm-power,mitsuba-scalar,cycles-tree,cycles-notree,luxcore")
ap.add_argument("--spp", default="1,4,16,64,256")
ap.add_argument("--res", type=int, default=128)
ap.add_argument("--ref-spp", type=int, default=8192)
ap.add_argument("--ref-power", default="many_lights", help="scenes whose reference picks lights by power: less noise there")
ap.add_argument("--octray", default=os.environ.get("OCTRAY", "target/release/octray"))
ap.add_argument("--strategies", default="mis-power")
a = ap.parse_args()

sys.path.insert(0, os.path.abspath(a.peers))
import numpy as np
import OpenEXR
import scenes

out = os.path.abspath(a.out)
work = os.path.join(out, "others")
images = os.path.join(scenes.PEERS, "img")
os.makedirs(work, exist_ok=True)
names = a.scenes.split(",")


def channels(image, prefix=""):
    """The layers of a linear image, row 0 at the top, as OpenEXR wants them."""
    return {prefix + c: np.ascontiguousarray(image[..., i], np.float32) for i, c in enumerate("RGB")}


def save(path, layers):
    header = dict(compression=OpenEXR.ZIP_COMPRESSION, type=OpenEXR.scanlineimage)
    OpenEXR.File(header, layers).write(path)


rows, references, files = [], [], []
for name in names:
    power = name in a.ref_power.split(",")
    subprocess.run([sys.executable, os.path.join(a.peers, "error_time.py"), name, "--res", str(a.res), "--spp", a.spp, "--ref-spp",
                    str(a.ref_spp), "--peers", a.renderers, "--results", work] + ["--ref-power"] * power, check=True)
    stem = f"{images}/ref_{name}_{a.res}_{'power' if power else 'uniform'}_{a.ref_spp // 8}"
    references.append(os.path.join(work, f"{name}-reference.exr"))
    save(references[-1], channels(np.load(stem + ".npy")) | channels(np.load(stem + "_var.npy"), "variance."))
    with open(os.path.join(work, name + ".json")) as file:
        results = json.load(file)["rows"]
    for row in results:
        if "seconds" not in row:
            continue
        image = f"{name}-{row['peer']}-{row['spp']}.exr"
        save(os.path.join(work, image), channels(np.load(f"{images}/{name}_{a.res}_{row['peer']}_{row['spp']}.npy")))
        rows.append([row["peer"], row["seconds"], image, name, row["spp"]])
    scene = scenes.SCENES[name]()
    scenes.export_obj(scene)
    scenes.export_toml(scene)
    files.append(os.path.join(scenes.OUT, name + ".toml"))

against = os.path.join(work, "others.csv")
with open(against, "w", newline="") as file:
    table = csv.writer(file, lineterminator="\n")
    table.writerow(["name", "seconds", "image", "scene", "spp"])
    table.writerows(rows)
command = [a.octray, "converge", *files, "--out", out, "--against", against, "--strategies", a.strategies, "--spps", a.spp,
           "--width", str(a.res), "--height", str(a.res), "--threads", "1"]
for reference in references:
    command += ["--reference", reference]
sys.exit(subprocess.run(command).returncode)
