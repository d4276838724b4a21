"""What the ROS tests share: scans of a box-shaped room as point cloud messages in any layout, waiting for conditions, and diagnostics."""
import os
import threading
import time

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import PointCloud2, PointField

LIMIT = float(os.environ.get('SGRAPH_TEST_LIMIT', 100))  # seconds of real time that anything may take on a busy machine

LAYOUT = [('x', PointField.FLOAT32), ('y', PointField.FLOAT32), ('z', PointField.FLOAT32), ('intensity', PointField.FLOAT32),
          ('ring', PointField.UINT16), ('time', PointField.FLOAT32)]
CODES = {PointField.FLOAT32: 'f', PointField.UINT16: 'H'}


def wait_for(condition, limit=LIMIT):
    """True as soon as the condition holds, False when it takes too long. Real time: simulated time may stand still."""
    end = time.monotonic() + limit
    while time.monotonic() < end and not rospy.is_shutdown():
        if condition():
            return True
        time.sleep(0.02)
    return False


def box_points(size=(8.0, 6.0, 2.8), height=1.2, rings=16, steps=900):
    """What a 16-ring LiDAR sees from the middle of a box: (n, 3) float32 and the ring of each point."""
    elevation = np.radians(np.linspace(-15, 15, rings))
    azimuth = np.linspace(0, 2 * np.pi, steps, endpoint=False)
    azimuth, elevation = np.meshgrid(azimuth, elevation)
    rays = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1)
    low = np.array([-size[0] / 2, -size[1] / 2, -height])
    high = np.array([size[0] / 2, size[1] / 2, size[2] - height])
    with np.errstate(divide='ignore', invalid='ignore'):
        reach = np.where(rays > 0, high / rays, np.where(rays < 0, low / rays, np.inf)).min(axis=-1)
    points = (rays * reach[..., None]).astype(np.float32)
    ring = np.broadcast_to(np.arange(rings)[:, None], reach.shape)
    return points.reshape(-1, 3), ring.reshape(-1).astype(np.uint16)


def cloud_message(stamp, points, ring, layout=None, frame='velodyne'):
    """A PointCloud2 with the given fields, packed in the given order."""
    layout = LAYOUT if layout is None else layout
    values = {'x': points[:, 0], 'y': points[:, 1], 'z': points[:, 2], 'ring': ring, 'intensity': np.arange(len(points)) % 100,
              'time': np.zeros(len(points))}
    dtype = np.dtype([(name, '<' + CODES[kind]) for name, kind in layout])
    data = np.zeros(len(points), dtype)
    for name, _ in layout:
        data[name] = values[name]
    message = PointCloud2(height=1, width=len(points), point_step=dtype.itemsize, row_step=dtype.itemsize * len(points), is_dense=True)
    message.header.stamp = stamp
    message.header.frame_id = frame
    message.fields = [PointField(name, dtype.fields[name][1], kind, 1) for name, kind in layout]
    message.data = data.tobytes()
    return message


def read_points(message):
    """Any PointCloud2 as a dictionary of arrays by field name."""
    formats = [{PointField.FLOAT32: '<f4', PointField.UINT16: '<u2'}[field.datatype] for field in message.fields]
    dtype = np.dtype({'names': [f.name for f in message.fields], 'formats': formats, 'offsets': [f.offset for f in message.fields],
                      'itemsize': message.point_step})
    array = np.frombuffer(message.data, dtype)
    return {name: array[name] for name in array.dtype.names}


class Recorder:
    """Keeps all messages of a topic."""

    def __init__(self, topic, kind):
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=1000)

    @property
    def last(self):
        return self.messages[-1] if self.messages else None


class Diagnostics:
    """The newest status of each nodelet, and every text that one has shown."""

    def __init__(self):
        self.lock = threading.Lock()
        self.newest = {}
        self.said = set()
        self.subscriber = rospy.Subscriber('/diagnostics', DiagnosticArray, self.take, queue_size=100)

    def take(self, message):
        with self.lock:
            for status in message.status:
                self.newest[status.name] = status
                self.said.add((status.name, status.level, status.message))

    def has_said(self, nodelet, level, text):
        """That text, at that level or a worse one that came with it."""
        with self.lock:
            return any(nodelet in name and said_level >= level and text in message for name, said_level, message in self.said)

    def value(self, nodelet, key):
        with self.lock:
            for name, status in self.newest.items():
                if nodelet in name:
                    for entry in status.values:
                        if entry.key == key:
                            return entry.value
        return None
