"""What the paper prints of itself and of others (Tables I and II), and what there is beside it."""

# System: (ATE RMSE, ATE STD, RPE translation [m], RPE rotation [deg]); the last pose of each run
# was aligned by Horn's method over all poses.
TABLE_1 = {
    "MH_04_difficult": {
        "OKVIS": (0.184569, 0.056455, 0.280032, 1.008995),
        "VINS-MONO": (0.139038, 0.088764, 0.271694, 1.535694),
        "PIRVS, the paper": (0.122709, 0.049498, 0.339272, 1.450916)},
    "PennCOSYVIO AS": {
        "OKVIS": (0.629347, 0.353461, 1.683979, 3.096804),
        "VINS-MONO": (1.276582, 0.680134, 1.985967, 2.121836),
        "PIRVS, the paper": (0.592735, 0.180257, 1.600193, 2.654375)},
}

PARTS = ("Image processing", "Matching", "Tracking", "Mapping", "End-to-end")

# Milliseconds a stereo frame on PennCOSYVIO AS; OKVIS tracks and maps in one.
TABLE_2 = {
    "OKVIS, PC": (5.4, 4.6, 39.7, None, 49.7),
    "OKVIS, PIRVS hardware": (16.3, 19.3, 93.8, None, 129.4),
    "PIRVS, the paper, PC": (8.7, 0.7, 3.6, 5.9, 18.9),
    "PIRVS, the paper, PIRVS hardware": (30, 3.8, 8.5, 57.2, 99.5),
}

EUROC = ("MH_01_easy", "MH_02_easy", "MH_03_medium", "MH_04_difficult", "MH_05_difficult",
         "V1_01_easy", "V1_02_medium", "V1_03_difficult", "V2_01_easy", "V2_02_medium",
         "V2_03_difficult")
TUM_VI = tuple(f"dataset-room{n}_512_16" for n in range(1, 7))
PENNCOSYVIO = ("as", "af", "bs", "bf")

# PennCOSYVIO's truth is of its rig, the middle GoPro; its site gives the rig's coordinates in those
# of the VI sensor's IMU: R row by row, then t in metres.
RIG_TO_IMU = ((0.9989551739, -0.0016800380, -0.0456698809, -0.0310),
              (0.0005817624, 0.9997105684, -0.0240508012, -0.1257),
              (0.0456970689, 0.0239991032, 0.9986670221, -0.0171))
