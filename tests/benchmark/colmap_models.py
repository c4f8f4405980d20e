"""Files between a rendered clip, COLMAP and `kinetrace evaluate`; called by tests/benchmark/colmap.

prepare CLIP FOLDER MIN_PIXELS: pictures of both views in one folder, and masks of the background and of each object
run CLIP RUN FOLDER OUT:        RUN with COLMAP's poses of the camera and the objects
table FOLDER:                   the table
"""
import csv
import json
import math
import pathlib
import shutil
import statistics
import sys

from PIL import Image

SIDES = ("left", "right")


def drive_of(clip):
    return next(pathlib.Path(clip).glob("*/*_sync"))


def lens_of(clip):
    """fx, fy, cx, cy in pixels, baseline in metres."""
    calibration = next(pathlib.Path(clip).glob("*/calib_cam_to_cam.txt")).read_text()
    rows = dict(line.split(": ", 1) for line in calibration.splitlines() if ": " in line)
    left, right = ([float(v) for v in rows[f"P_rect_0{i}"].split()] for i in (0, 1))
    return left[0], left[5], left[2], left[6], (left[3] - right[3]) / left[0]


def instances(clip, side, stem):
    """Values of the exact masks: 1000 * class + number, 0 for the background."""
    picture = Image.open(pathlib.Path(clip) / "truth/masks" / f"instances_{side}" / f"{stem}.png")
    return picture.size, picture.tobytes()


def counts_of(pixels):
    counts = {}
    for value in memoryview(pixels).cast("H"):
        counts[value] = counts.get(value, 0) + 1
    return counts


def mask_for(size, pixels, value):
    """White on the body."""
    values = memoryview(pixels).cast("H")
    return Image.frombytes("L", size, bytes(255 if v == value else 0 for v in values))


def prepare(clip, folder, min_pixels):
    folder = pathlib.Path(folder)
    if (folder / "lens").exists():
        return
    images = folder / "images"
    images.mkdir(parents=True, exist_ok=True)
    stems = sorted(p.stem for p in (drive_of(clip) / "image_00/data").glob("*.png"))
    largest = {0: math.inf}
    seen = {}
    for stem in stems:
        for i, side in enumerate(SIDES):
            shutil.copy(drive_of(clip) / f"image_0{i}/data/{stem}.png", images / f"{stem}_{side}.png")
            _, pixels = instances(clip, side, stem)
            for value, count in counts_of(pixels).items():
                if value != 0:
                    largest[value] = max(largest.get(value, 0), count)
                seen.setdefault(value, []).append((stem, side))
    for value, count in largest.items():
        if count < min_pixels:
            continue
        body = folder / f"body_{value}"
        (body / "masks").mkdir(parents=True, exist_ok=True)
        for stem, side in seen[value]:
            size, pixels = instances(clip, side, stem)
            mask_for(size, pixels, value).save(body / "masks" / f"{stem}_{side}.png.png")
        (body / "list").write_text("".join(f"{stem}_{side}.png\n" for stem, side in seen[value]))
    fx, fy, cx, cy, _ = lens_of(clip)
    # COLMAP has the centre of the first pixel at (0.5, 0.5).
    (folder / "lens").write_text(f"{fx},{fy},{cx + 0.5},{cy + 0.5}")


# Rotations are three rows; poses are (R, t).


def rotation(w, x, y, z):
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def quaternion(R):
    """x, y, z, w."""
    w = math.sqrt(max(0.0, 1 + R[0][0] + R[1][1] + R[2][2])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1 + R[0][0] - R[1][1] - R[2][2])) / 2, R[2][1] - R[1][2])
    y = math.copysign(math.sqrt(max(0.0, 1 - R[0][0] + R[1][1] - R[2][2])) / 2, R[0][2] - R[2][0])
    z = math.copysign(math.sqrt(max(0.0, 1 - R[0][0] - R[1][1] + R[2][2])) / 2, R[1][0] - R[0][1])
    return x, y, z, w


def turned(R, v):
    return tuple(sum(R[i][k] * v[k] for k in range(3)) for i in range(3))


def product(a, b):
    R = tuple(tuple(sum(a[0][i][k] * b[0][k][j] for k in range(3)) for j in range(3)) for i in range(3))
    return R, tuple(p + q for p, q in zip(turned(a[0], b[1]), a[1]))


def inverse(T):
    R = tuple(zip(*T[0]))
    return R, tuple(-v for v in turned(R, T[1]))


def largest_model(body):
    """T_cam_body by (stem, side) of the model with the most pictures; empty where there is none."""
    best = {}
    for file in body.glob("sparse/*/images.txt"):
        lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
        poses = {}
        for line in lines[::2]:
            fields = line.split()
            w, x, y, z, *t = (float(v) for v in fields[1:8])
            stem, side = fields[9].removesuffix(".png").rsplit("_", 1)
            poses[stem, side] = (rotation(w, x, y, z), tuple(t))
        best = max(best, poses, key=len)
    return best


def metric(poses, baseline_m):
    """T_body_cam of the left camera in metres, by frame: the pairs' baselines give the scale."""
    centres = {key: inverse(T)[1] for key, T in poses.items()}
    widths = [math.dist(centre, centres[stem, "right"]) for (stem, side), centre in centres.items()
              if side == "left" and (stem, "right") in centres]
    if not widths or statistics.median(widths) <= 0.0:
        return {}
    scale = baseline_m / statistics.median(widths)
    return {int(stem): inverse((R, tuple(scale * v for v in t)))
            for (stem, side), (R, t) in poses.items() if side == "left"}


def best_track(run, value, clip):
    """The track whose masks most often cover the object's."""
    with open(run / "objects.csv", newline="") as rows:
        tracks = list(csv.DictReader(rows))
    votes = {}
    for row in tracks:
        x = (int(row["mask_x0"]) + int(row["mask_x1"])) // 2
        y = (int(row["mask_y0"]) + int(row["mask_y1"])) // 2
        size, pixels = instances(clip, "left", f"{int(row['frame']):010d}")
        if x < size[0] and y < size[1] and memoryview(pixels).cast("H")[y * size[0] + x] == value:
            votes[row["track_id"]] = votes.get(row["track_id"], 0) + 1
    return max(votes, key=votes.get, default=None)


def pose_text(T):
    return [f"{v:.9g}" for v in (*T[1], *quaternion(T[0]))]


def kitti_text(T):
    return " ".join(f"{v:.9g}" for row, t in zip(*T) for v in (*row, t))


def write_camera(run, out, camera):
    lines = (run / "camera.tum").read_text().splitlines()
    frames = [int(row["frame"]) for row in csv.DictReader(open(run / "objects.csv", newline=""))]
    first = min(frames, default=0)
    kept = [(line.split()[0], camera[first + i]) for i, line in enumerate(lines) if first + i in camera]
    (out / "camera.tum").write_text("".join(f"{time} {' '.join(pose_text(T))}\n" for time, T in kept))
    (out / "camera_kitti.txt").write_text("".join(kitti_text(T) + "\n" for _, T in kept))


def make_run(clip, run, folder, out):
    run, folder, out = (pathlib.Path(p) for p in (run, folder, out))
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(run, out)
    baseline_m = lens_of(clip)[4]
    camera = metric(largest_model(folder / "body_0"), baseline_m)
    T_first = inverse(camera[min(camera)])
    camera = {frame: product(T_first, T) for frame, T in camera.items()}
    objects = {}
    for body in sorted(folder.glob("body_*")):
        value = int(body.name.removeprefix("body_"))
        track = best_track(run, value, clip) if value else None
        if track is not None:
            objects[track] = metric(largest_model(body), baseline_m)
    write_camera(run, out, camera)
    with open(run / "objects.csv", newline="") as rows:
        reader = csv.DictReader(rows)
        columns = reader.fieldnames
        table = list(reader)
    for row in table:
        T_obj_cam = objects.get(row["track_id"], {}).get(int(row["frame"]))
        if T_obj_cam is None or int(row["frame"]) not in camera:
            row["status"] = "lost"
            continue
        row["status"] = "tracked"
        T_world_obj = product(camera[int(row["frame"])], inverse(T_obj_cam))
        row.update(zip(("tx", "ty", "tz", "qx", "qy", "qz", "qw"), pose_text(T_world_obj)))
    with open(out / "objects.csv", "w", newline="") as rows:
        writer = csv.DictWriter(rows, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    registered = {"camera": len(camera), **{track: len(frames) for track, frames in objects.items()}}
    (out / "registered.json").write_text(json.dumps(registered))


def cost_of(files):
    steps = [line.split() for file in files for line in file.read_text().splitlines() if line[0].isdigit()]
    return sum(float(user) + float(system) for user, system, _ in steps), max(int(k) for *_, k in steps) / 1024


def table(folder):
    folder = pathlib.Path(folder)
    costs = {
        "online": [folder / "online.cost"],
        "refined": [folder / "online.cost", folder / "refined.cost"],
        "by_colmap": sorted(folder.glob("colmap/body_*/cost")),
    }
    names = {"online": "`kinetrace run`", "refined": "`run`, then `refine`", "by_colmap": "COLMAP"}
    print("| | drift, % | position, m | objects' motion, m | degrees | rows with a pose, % | processor time, s | memory, MiB |")
    print("|---|---|---|---|---|---|---|---|")
    for run, name in names.items():
        result = json.loads((folder / run / "evaluation.json").read_text())
        objects, camera = result["objects"], result["camera"]
        seconds, mebibytes = cost_of(costs[run])
        values = [
            (camera["t_rel"], 3), (camera["ate"]["first"]["rmse"], 4),
            (objects["motion"]["translation"]["mean"], 4), (objects["motion"]["rotation"]["mean"], 3),
            (objects["coverage"], 1), (seconds, 0), (mebibytes, 0),
        ]
        print(f"| {name} | " + " | ".join("-" if v is None else f"{v:.{d}f}" for v, d in values) + " |")


if __name__ == "__main__":
    command, *arguments = sys.argv[1:]
    if command == "prepare":
        prepare(arguments[0], arguments[1], int(arguments[2]))
    elif command == "run":
        make_run(*arguments)
    else:
        table(*arguments)
