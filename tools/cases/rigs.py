"""Calibrations in the forms of other stacks, written from an ASL folder's, and images turned.

A writer of its own: it shares no code with the readers that it tests.
"""
import json
import re
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "lib"))
from rotation import quaternion


class Camera:
    def __init__(self, size, k, d, T):
        self.size, self.k, self.d, self.T = size, k, d, T  # T: camera to IMU, 16 numbers


def numbers(text, key):
    """The list behind a key of a sensor.yaml."""
    found = re.search(key + r":\s*(?:\n[^\[]*data:\s*)?\[([^\]]*)\]", text)
    return [float(word) for word in found[1].replace("\n", " ").split(",")]


def camera_of(path):
    text = Path(path).read_text()
    return Camera([int(n) for n in numbers(text, "resolution")], numbers(text, "intrinsics"),
                  numbers(text, "distortion_coefficients"), numbers(text, "T_BS"))


def euroc(clip):
    return [camera_of(clip / f"mav0/cam{c}/sensor.yaml") for c in (0, 1)]


def inverse(T):
    R = [T[0:3], T[4:7], T[8:11]]
    p = [T[3], T[7], T[11]]
    out = []
    for i in range(3):
        out += [R[0][i], R[1][i], R[2][i], -sum(R[k][i] * p[k] for k in range(3))]
    return out + [0.0, 0.0, 0.0, 1.0]


def product(A, B):
    return [sum(A[4 * i + k] * B[4 * k + j] for k in range(4)) for i in range(4) for j in range(4)]


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def write_imu(path, gyro=1.6968e-4, gyro_walk=1.9393e-5, accel=2.0e-3, accel_walk=3.0e-3):
    return write(path, f"gyroscope_noise_density: {gyro}\ngyroscope_random_walk: {gyro_walk}\n"
                 f"accelerometer_noise_density: {accel}\naccelerometer_random_walk: {accel_walk}\n"
                 "update_rate: 200.0\n")


def write_kalibr(cameras, path, shifts=(0, 0), pose="T_cam_imu"):
    text = ""
    for c, camera in enumerate(cameras):
        T = inverse(camera.T) if pose == "T_cam_imu" else camera.T
        rows = "".join(f"  - {T[4 * i:4 * i + 4]}\n" for i in range(4))
        text += (f"cam{c}:\n  {pose}:\n{rows}  camera_model: pinhole\n  intrinsics: {camera.k}\n"
                 f"  distortion_model: radtan\n  distortion_coeffs: {camera.d}\n"
                 f"  resolution: {camera.size}\n  timeshift_cam_imu: {shifts[c]}\n")
    return write(path, text)


def chain(cameras, folder):
    return write_kalibr(cameras, folder / "camchain-imucam.yaml")


def openvins(cameras, folder):
    write_kalibr(cameras, folder / "kalibr_imucam_chain.yaml", pose="T_imu_cam")
    imu = write_imu(folder / "imu_chain.yaml")
    imu.write_text("imu0:\n" + "".join(f"  {line}\n" for line in imu.read_text().splitlines()))
    return write(folder / "estimator_config.yaml", '%YAML:1.0\nverbosity: "INFO"\nmax_cameras: 2\n'
                 'relative_config_imu: "imu_chain.yaml"\n'
                 'relative_config_imucam: "kalibr_imucam_chain.yaml"\n')


def basalt(cameras, folder):
    poses, lenses = [], []
    for camera in cameras:
        T = camera.T
        q = quaternion([T[0:3], T[4:7], T[8:11]])
        poses.append(dict(px=T[3], py=T[7], pz=T[11], qx=q[0], qy=q[1], qz=q[2], qw=q[3]))
        names = dict(zip(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"), camera.k + camera.d))
        names.update(k3=0, k4=0, k5=0, k6=0, rpmax=0)
        lenses.append({"camera_type": "pinhole-radtan8", "intrinsics": names})
    value = {"T_imu_cam": poses, "intrinsics": lenses, "resolution": [c.size for c in cameras],
             "calib_accel_bias": [0] * 9, "calib_gyro_bias": [0] * 12, "imu_update_rate": 200.0,
             "accel_noise_std": [2.0e-3] * 3, "gyro_noise_std": [1.6968e-4] * 3,
             "accel_bias_std": [3.0e-3] * 3, "gyro_bias_std": [1.9393e-5] * 3,
             "cam_time_offset_ns": 0, "vignette": []}
    return write(folder / "calib.json", json.dumps({"value0": value}, indent="\t"))


def opencv(name, T):
    return f"{name}: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: {T}\n"


def orbslam(cameras, folder):
    text = '%YAML:1.0\n---\nFile.version: "1.0"\nCamera.type: "PinHole"\n'
    for c, camera in enumerate(cameras, 1):
        for name, value in zip(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"),
                               camera.k + camera.d):
            text += f"Camera{c}.{name}: {value!r}\n"
    text += f"Camera.width: {cameras[0].size[0]}\nCamera.height: {cameras[0].size[1]}\n"
    text += "Camera.newWidth: 600\nCamera.newHeight: 350\nCamera.fps: 20\nStereo.ThDepth: 60.0\n"
    text += opencv("Stereo.T_c1_c2", product(inverse(cameras[0].T), cameras[1].T))
    text += opencv("IMU.T_b_c1", cameras[0].T)
    text += ("IMU.NoiseGyro: 1.6968e-04\nIMU.NoiseAcc: 2.0000e-3\nIMU.GyroWalk: 1.9393e-05\n"
             "IMU.AccWalk: 3.e-03\nIMU.Frequency: 200.0\n")
    return write(folder / "EuRoC.yaml", text)


def vins(cameras, folder):
    text = "%YAML:1.0\n\nimu: 1\nnum_of_cam: 2\nestimate_extrinsic: 0\n"
    for c, camera in enumerate(cameras):
        text += f'cam{c}_calib: "cam{c}_pinhole.yaml"\n' + opencv(f"body_T_cam{c}", camera.T)
        values = camera.k + camera.d
        lens = f"%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: cam{c}\n"
        lens += f"image_width: {camera.size[0]}\nimage_height: {camera.size[1]}\n"
        lens += "distortion_parameters:\n" + "".join(
            f"   {n}: {v!r}\n" for n, v in zip(("k1", "k2", "p1", "p2"), values[4:]))
        lens += "projection_parameters:\n" + "".join(
            f"   {n}: {v!r}\n" for n, v in zip(("fx", "fy", "cx", "cy"), values[:4]))
        write(folder / f"cam{c}_pinhole.yaml", lens)
    text += "acc_n: 0.002\ngyr_n: 0.00016968\nacc_w: 0.003\ngyr_w: 1.9393e-05\ntd: 0.0\n"
    return write(folder / "euroc_stereo_imu_config.yaml", text)


def okvis(cameras, folder):
    text = "%YAML:1.0\ncameras:\n"
    for camera in cameras:
        text += (f"    - {{T_SC:\n        {camera.T},\n        image_dimension: {camera.size},\n"
                 f"        distortion_coefficients: {camera.d},\n"
                 "        distortion_type: radialtangential,\n"
                 f"        focal_length: {camera.k[:2]},\n"
                 f"        principal_point: {camera.k[2:]}}}\n")
    text += ("camera_parameters:\n    timestamp_tolerance: 0.005\n    image_delay: 0.0\n"
             "imu_parameters:\n    use: true\n    a_max: 176.0\n    sigma_g_c: 1.6968e-4\n"
             "    sigma_a_c: 2.0e-3\n    sigma_gw_c: 1.9393e-5\n    sigma_aw_c: 3.0e-3\n"
             "    T_BS:\n      [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0,\n"
             "       0.0, 0.0, 0.0, 1.0]\n")
    return write(folder / "euroc.yaml", text)


def depthai(cameras, folder):
    """The right camera against the left one, the IMU against the left one; in cm."""
    def link(T, socket):
        translation = dict(zip("xyz", (100 * T[3], 100 * T[7], 100 * T[11])))
        return {"rotationMatrix": [T[0:3], T[4:7], T[8:11]], "toCameraSocket": socket,
                "translation": translation, "specTranslation": translation}

    none = {"rotationMatrix": [], "toCameraSocket": -1,
            "translation": dict(x=0, y=0, z=0), "specTranslation": dict(x=0, y=0, z=0)}
    data = []
    for socket, camera in enumerate(cameras, 1):
        fx, fy, cx, cy = camera.k
        T = product(inverse(cameras[0].T), camera.T)
        data.append([socket, {"cameraType": 0, "width": camera.size[0], "height": camera.size[1],
                              "intrinsicMatrix": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]],
                              "distortionCoeff": camera.d + [0] * 10, "lensPosition": 0,
                              "extrinsics": none if socket == 1 else link(T, 1)}])
    write_imu(folder / "imu.yaml")
    return write(folder / "oak.json", json.dumps(
        {"boardName": "DM9098", "cameraData": data, "version": 7,
         "imuExtrinsics": link(inverse(cameras[0].T), 1),
         "stereoRectificationData": {"leftCameraSocket": 1, "rightCameraSocket": 2}}, indent=4))


def realsense(cameras, folder):
    text = "Intrinsic Parameters:\n\n"
    for n, camera in enumerate(cameras, 1):
        for part in (2, 1):  # of another size, too
            width, height = (side // part for side in camera.size)
            text += f' Intrinsic of "Infrared {n}" / {width}x{height} / {{Y8}}\n'
            names = ("Fx", "Fy", "PPX", "PPY")
            for name, value in [("Width", width), ("Height", height),
                                *zip(names, (k / part for k in camera.k)),
                                ("Distortion", "Brown Conrady")]:
                text += f"  {name + ':':<12}\t{value}\n"
            text += "  Coeffs:     " + "".join(f"\t{d}  " for d in camera.d + [0.0]) + "\n\n"
    text += "\nExtrinsic Parameters:\n"
    for n, camera in enumerate(cameras, 1):
        T = camera.T
        rows = "".join("".join(f"   {v!r}" for v in T[i:i + 3]) + "\n" for i in (0, 4, 8))
        text += (f'Extrinsic from "Infrared {n}"\t  To\t  "Gyro" :\n Rotation Matrix:\n{rows}\n'
                 f" Translation Vector: {T[3]!r}  {T[7]!r}  {T[11]!r}  \n\n")
    write_imu(folder / "imu.yaml")
    return write(folder / "d435i.txt", text)


FAMILIES = {"Kalibr": chain, "OpenVINS": openvins, "Basalt": basalt, "ORB-SLAM3": orbslam,
            "VINS-Fusion": vins, "OKVIS2": okvis, "DepthAI": depthai, "RealSense": realsense}


def turn(folder, cv2, how):
    """The images of a camera and its sensor.yaml, turned clockwise."""
    quarters = {cv2.ROTATE_90_CLOCKWISE: 1, cv2.ROTATE_180: 2, cv2.ROTATE_90_COUNTERCLOCKWISE: 3}
    source = (folder / "data").resolve()
    (folder / "data").unlink()
    (folder / "data").mkdir()
    for line in (folder / "data.csv").read_text().splitlines():
        if line[0] != "#":
            name = line.split(",")[1].strip()
            image = cv2.imread(str(source / name), cv2.IMREAD_GRAYSCALE)
            cv2.imwrite(str(folder / "data" / name), cv2.rotate(image, how),
                        [cv2.IMWRITE_JPEG_QUALITY, 100])
    camera = camera_of(folder / "sensor.yaml")
    for _ in range(quarters[how]):
        fx, fy, cx, cy = camera.k
        k1, k2, p1, p2 = camera.d
        camera.k = [fy, fx, camera.size[1] - 1 - cy, cx]
        camera.d = [k1, k2, p2, -p1]
        camera.size = camera.size[::-1]
        camera.T = product(camera.T, [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    write(folder / "sensor.yaml",
          f"T_BS:\n  cols: 4\n  rows: 4\n  data: {camera.T}\nresolution: {camera.size}\n"
          f"camera_model: pinhole\nintrinsics: {camera.k}\ndistortion_model: radial-tangential\n"
          f"distortion_coefficients: {camera.d}\n")
