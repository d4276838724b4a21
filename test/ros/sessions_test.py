#!/usr/bin/python3
"""Maps that are kept, live: a map is written while the robot drives, taken up again to localise in it or to go on with it, by launch parameters and by
the service load; pause, resume, reset and initialpose; and what is refused."""
import contextlib
import math
import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
import roslib.packages
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import PointCloud2
from sgraph_slam.msg import OdometryStatus, SceneGraph
from sgraph_slam.srv import LoadMap
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from support import LIMIT, Diagnostics, Recorder, cloud_message, wait_for

# Seen from above [m]; the robot's frame begins at the world's origin. One room has no symmetry, the other looks the same when it is turned by half.
L_SHAPE = [(-2, -2), (7, -2), (7, 2), (2, 2), (2, 5), (-2, 5)]
RECTANGLE = [(-2, -2), (7, -2), (7, 2.5), (-2, 2.5)]
MIDDLE = (2.5, 0.25)  # of the rectangle
FLOOR, CEILING = -0.6, 2.2  # from the sensor [m]


def scan(corners, x, y, yaw, steps=450, rings=16):
    """What a 16-ring LiDAR sees in a room with these corners (counter-clockwise): (n, 3) float32 in its own frame, and the ring of each point."""
    azimuth = np.linspace(0, 2 * np.pi, steps, endpoint=False)
    direction = np.stack([np.cos(azimuth + yaw), np.sin(azimuth + yaw)], axis=-1)
    reach = np.full(steps, np.inf)
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        ex, ey = bx - ax, by - ay
        with np.errstate(divide='ignore', invalid='ignore'):
            det = direction[:, 0] * ey - direction[:, 1] * ex
            t = ((ax - x) * ey - (ay - y) * ex) / det
            s = ((ax - x) * direction[:, 1] - (ay - y) * direction[:, 0]) / det
        hit = (t > 0) & (s >= 0) & (s <= 1)
        reach[hit] = np.minimum(reach[hit], t[hit])
    elevation = np.radians(np.linspace(-15, 15, rings))[:, None]
    level = np.broadcast_to(reach, (rings, steps)).copy()  # horizontal distance
    height = np.tan(elevation) * level
    level = np.where(height < FLOOR, FLOOR / np.tan(np.minimum(elevation, -1e-9)), level)
    level = np.where(height > CEILING, CEILING / np.tan(np.maximum(elevation, 1e-9)), level)
    noise = 1 + np.random.default_rng(abs(int(1e6 * (x + 3 * y + 7 * yaw)))).normal(0, 0.002, level.shape)
    points = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.tan(elevation) * level], axis=-1) * noise[..., None]
    ring = np.broadcast_to(np.arange(rings)[:, None], level.shape)
    return points.reshape(-1, 3).astype(np.float32), ring.reshape(-1).astype(np.uint16)


class Robot:
    """A node in a namespace of its own, and a robot that drives to and fro along a line in a room."""

    def __init__(self, name, folder, corners, start=(0.0, 0.0, 0.0), **settings):
        self.name, self.corners, self.start = name, corners, start
        rospy.set_param(f'/{name}/config/ros', {'base_to_lidar': '0 0 0 0 0 0', 'map_directory': folder, **settings})
        rospy.set_param(f'/{name}/config/odometry/keyframe', {'distance': 0.4})
        self.status = Recorder(f'/{name}/odometry_status', OdometryStatus)
        self.graph = Recorder(f'/{name}/graph', SceneGraph)
        self.pose = rospy.Publisher(f'/{name}/initialpose', PoseWithCovarianceStamped, queue_size=1)
        self.publisher = rospy.Publisher(f'/{name}/points', PointCloud2, queue_size=100)
        command = [roslib.packages.find_node('sgraph_slam', 'sgraph_slam_node')[0], f'__ns:=/{name}', '__name:=slam']
        self.process = subprocess.Popen(command)
        self.steps = 0
        assert wait_for(lambda: self.publisher.get_num_connections() > 0 and self.status.subscriber.get_num_connections() > 0
                        and self.graph.subscriber.get_num_connections() > 0), f'{name} did not start'

    def drive(self, scans):
        """0.1 m a scan, 3 m along the start's heading and back."""
        for _ in range(scans):
            n = self.steps % 60
            along = 0.1 * (n if n <= 30 else 60 - n)
            x, y, yaw = self.start
            points, ring = scan(self.corners, x + along * math.cos(yaw), y + along * math.sin(yaw), yaw)
            before = len(self.status.messages)
            self.publisher.publish(cloud_message(rospy.Time.from_sec(1000 + 0.1 * self.steps), points, ring))
            self.steps += 1
            # The sensor's conventions are recognised from the first scans, which are held until then.
            wait_for(lambda n=before: len(self.status.messages) > n, LIMIT if self.steps > 60 else 0.05)

    def drive_until(self, condition, most=240):
        for _ in range(most // 10):
            self.drive(10)
            if wait_for(condition, 1):
                return True
        return wait_for(condition, LIMIT)

    def keyframes(self):
        return len(self.graph.last.keyframes) if self.graph.last else 0

    def trigger(self, name):
        return rospy.ServiceProxy(f'/{self.name}/{name}', Trigger)()

    def load(self, path):
        return rospy.ServiceProxy(f'/{self.name}/load', LoadMap)(path)

    def show(self, x, y, yaw, frame='map'):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = frame
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        assert wait_for(lambda: self.pose.get_num_connections() > 0)
        self.pose.publish(message)

    def stop(self):
        begin = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        status = self.process.wait(timeout=LIMIT)
        print(f'{self.name}: stopped after {time.monotonic() - begin:.2f} s')
        return status


def count(path, table):
    # Closed at once: the file's last connection must be the writer's, which puts it together.
    with contextlib.closing(sqlite3.connect(f'file:{path}?mode=ro', uri=True)) as database:
        return database.execute(f'SELECT count(*) FROM {table}').fetchone()[0]


class Sessions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.diagnostics = Diagnostics()
        cls.transforms = Recorder('/tf', TFMessage)
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = cls.temporary.name

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        self.robots = []

    def tearDown(self):
        for robot in self.robots:
            if robot.process.poll() is None:
                robot.process.kill()
                robot.process.wait()

    def robot(self, *arguments, **settings):
        self.robots.append(Robot(*arguments, **settings))
        return self.robots[-1]

    def file(self, name):
        return os.path.join(self.folder, name)

    def place(self, robot):
        return (self.diagnostics.value(f'{robot.name}/mapping', 'place in the map') or '').split(':')[0]

    def has_map_transform(self):
        return any(t.header.frame_id == 'map' for m in list(self.transforms.messages) for t in m.transforms)

    def make_map(self, name, corners):
        robot = self.robot(f'made_{name}', self.folder, corners)
        self.assertTrue(robot.drive_until(lambda: robot.keyframes() >= 12))
        self.assertEqual(robot.stop(), 0)
        os.rename(self.file('map.sgmap'), self.file(f'{name}.sgmap'))
        self.assertGreaterEqual(count(self.file(f'{name}.sgmap'), 'keyframes'), 12)
        self.assertEqual([n for n in os.listdir(self.folder) if n.endswith(('-wal', '-shm'))], [], 'a finished map is one file')

    def test_1_a_map_is_localised_in(self):
        self.make_map('monday', L_SHAPE)
        with open(self.file('monday.sgmap'), 'rb') as file:
            before = file.read()
        robot = self.robot('tuesday', self.folder, L_SHAPE, start=(1.0, 0.5, 0.7), map='monday.sgmap', map_mode='localize')
        self.transforms.messages.clear()
        robot.drive(5)
        self.assertFalse(self.has_map_transform(), 'map -> odom before the place was known')
        self.assertTrue(robot.drive_until(lambda: self.place(robot) == 'found'), self.place(robot))
        self.assertTrue(wait_for(self.has_map_transform))
        newest = [t for m in self.transforms.messages for t in m.transforms if t.header.frame_id == 'map'][-1].transform
        self.assertAlmostEqual(newest.translation.x, 1.0, delta=0.1)
        self.assertAlmostEqual(newest.translation.y, 0.5, delta=0.1)
        self.assertAlmostEqual(2 * math.atan2(newest.rotation.z, newest.rotation.w), 0.7, delta=0.03)
        self.assertEqual(robot.stop(), 0)
        with open(self.file('monday.sgmap'), 'rb') as file:
            self.assertEqual(file.read(), before, 'localising changed the map')

    def test_2_a_map_is_gone_on_with_by_the_service(self):
        robot = self.robot('wednesday', self.folder, L_SHAPE, start=(1.0, 0.5, 0.7))
        self.assertFalse(robot.load('../elsewhere').success)
        refused = robot.load('none.sgmap')
        self.assertFalse(refused.success)
        self.assertIn('no such file', refused.message)
        with open(self.file('text.sgmap'), 'w', encoding='ascii') as file:
            file.write('no map ' * 1000)
        refused = robot.load('text.sgmap')
        self.assertFalse(refused.success)
        self.assertIn('no map file', refused.message)
        answer = robot.load('monday.sgmap')
        self.assertTrue(answer.success, answer.message)
        before = count(self.file('monday.sgmap'), 'keyframes')
        self.assertTrue(robot.drive_until(lambda: self.place(robot) == 'found'), self.place(robot))
        self.assertEqual(robot.stop(), 0)
        self.assertEqual(count(self.file('monday.sgmap'), 'sessions'), 2)
        self.assertGreater(count(self.file('monday.sgmap'), 'keyframes'), before)

    def test_3_pause_resume_reset(self):
        robot = self.robot('thursday', self.folder, L_SHAPE)
        self.assertTrue(robot.drive_until(lambda: robot.keyframes() >= 5))
        self.assertTrue(robot.trigger('pause').success)
        robot.trigger('optimize')  # waits for what came before
        paused = robot.keyframes()
        robot.drive(60)
        robot.trigger('optimize')
        self.assertEqual(robot.keyframes(), paused, 'keyframes entered the map while it was paused')
        self.assertTrue(robot.trigger('resume').success)
        self.assertTrue(robot.drive_until(lambda: robot.keyframes() > paused + 3))
        self.assertTrue(robot.trigger('reset').success)
        self.assertTrue(wait_for(lambda: robot.keyframes() == 0))
        self.assertTrue(robot.drive_until(lambda: robot.keyframes() >= 3))
        self.assertEqual(robot.stop(), 0)
        self.assertTrue(os.path.exists(self.file('map.before.sgmap')), 'the map before the reset is kept')
        self.assertGreater(count(self.file('map.before.sgmap'), 'keyframes'), paused)

    def test_4_rooms_that_look_the_same_need_a_hint(self):
        self.make_map('symmetric', RECTANGLE)
        robot = self.robot('friday', self.folder, RECTANGLE, start=(4.5, 0.5, math.pi), map='symmetric.sgmap', map_mode='localize')
        self.assertTrue(robot.drive_until(lambda: self.place(robot) == 'ambiguous'), self.place(robot))
        robot.show(4.5, 0.5, math.pi, frame='odom')
        self.assertTrue(wait_for(lambda: self.diagnostics.has_said('friday/mapping', DiagnosticStatus.ERROR, 'initial pose refused')))
        along = 0.1 * min(robot.steps % 60, 60 - robot.steps % 60)
        robot.show(4.5 - along, 0.5, math.pi)
        self.assertTrue(robot.drive_until(lambda: self.place(robot) == 'found'), self.place(robot))
        newest = [t for m in self.transforms.messages for t in m.transforms if t.header.frame_id == 'map'][-1].transform
        self.assertAlmostEqual(newest.translation.x, 4.5, delta=0.1)
        self.assertAlmostEqual(newest.translation.y, 0.5, delta=0.1)
        self.assertEqual(robot.stop(), 0)


if __name__ == '__main__':
    import rostest
    rospy.init_node('sessions_test')
    rostest.rosrun('sgraph_slam', 'sessions', Sessions, sys.argv)
