"""Figures of the paper: Bavle et al., Situational Graphs for Robot Navigation in Structured Indoor Environments, RA-L 2022, tables I to IV."""

ATE = {  # simulated data, LiDAR only [m]
    'HDL-SLAM': {'cf1': '0.09', 'cf2': '0.11', 'se1': '0.04', 'se2': '0.15'},
    'A-LOAM': {'cf1': '0.07', 'cf2': '0.10', 'se1': '0.16', 'se2': '0.32'},
    'M-LOAM': {'cf1': '0.15', 'cf2': '0.39', 'se1': '0.65', 'se2': '2.82'},
    'F-LOAM': {'cf1': '3.90', 'cf2': '0.44', 'se1': '0.15', 'se2': '0.24'},
    'SC-A-LOAM': {'cf1': '0.45', 'cf2': '0.43', 'se1': '0.43', 'se2': '0.64'},
    'S-Graph without topological layer': {'cf1': '0.05', 'cf2': '0.17', 'se1': '0.40', 'se2': '1.01'},
    'S-Graph': {'cf1': '0.04', 'cf2': '0.07', 'se1': '0.03', 'se2': '0.05'}}
MAP = {  # recorded data, encoder odometry [m]
    'HDL-SLAM': {'cf1': '1.34', 'cf2': '0.27', 'lc1': '1.45'},
    'A-LOAM': {'cf1': '8.03', 'cf2': '1.20', 'lc1': '3.14'},
    'M-LOAM': {'cf1': '3.73', 'cf2': '1.93', 'lc1': '1.68'},
    'F-LOAM': {'cf1': '7.63', 'cf2': '1.15', 'lc1': '2.90'},
    'SC-A-LOAM': {'cf1': '4.86', 'cf2': '0.75', 'lc1': '2.89'},
    'LeGO-LOAM': {'cf1': '4.08', 'cf2': '0.70', 'lc1': '3.40'},
    'S-Graph without topological layer': {'cf1': '1.21', 'cf2': '0.24', 'lc1': '1.45'},
    'S-Graph': {'cf1': '0.94', 'cf2': '0.26', 'lc1': '1.32'}}
END = {  # recorded data, encoder odometry [m] / [deg]
    'HDL-SLAM': {'le1': '0.03 / 0.17', 'le2': '0.24 / 0.06'},
    'A-LOAM': {'le1': '1.78 / 0.10', 'le2': '0.23 / 0.10'},
    'M-LOAM': {'le1': '3.60 / 0.04', 'le2': '11.2 / 0.42'},
    'F-LOAM': {'le1': '7.22 / 0.25', 'le2': '9.28 / 0.41'},
    'SC-A-LOAM': {'le1': '0.55 / 0.08', 'le2': '0.93 / 0.09'},
    'LeGO-LOAM': {'le1': '0.32 / 0.10', 'le2': '0.15 / 0.72'},
    'S-Graph without topological layer': {'le1': '0.49 / 0.12', 'le2': '0.32 / 0.05'},
    'S-Graph': {'le1': '0.08 / 0.14', 'le2': '0.11 / 0.04'}}
TIME = {  # recorded data, 16 cores, map optimisation, mean / std [ms]
    'HDL-SLAM': {'cf1': '3.9 / 4.2', 'cf2': '3.4 / 3.3', 'lc1': '8.1 / 7.7', 'le1': '22.5 / 19.4', 'le2': '10.3 / 10.8'},
    'A-LOAM': {'cf1': '3.3 / 2.1', 'cf2': '2.2 / 1.6', 'lc1': '3.6 / 1.9', 'le1': '5.1 / 1.8', 'le2': '5.2 / 3.6'},
    'S-Graph': {'cf1': '70 / 89.1', 'cf2': '83.8 / 85.3', 'lc1': '80.1 / 104.9', 'le1': '257.7 / 447.3', 'le2': '330.6 / 396.1'}}
LENGTH = {'cf1': 487, 'cf2': 657, 'lc1': 339, 'le1': 1321, 'le2': 1585}  # [s]
