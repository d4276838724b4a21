#!/usr/bin/python3
"""play.launch maps a simulated bag: tf, topics, services, the saved files, and the same keyframes as run_bag."""
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import roslib.packages
import rospy
import tf2_ros
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from sensor_msgs.msg import PointCloud2
from sgraph_slam.msg import Keyframe, PlaneSegments, SceneGraph
from sgraph_slam.srv import LoadMap, SaveMap
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from support import LIMIT, Diagnostics, Recorder, read_points, wait_for

SECONDS = 14  # of the recording
MAP_FILES = ['trajectory.tum', 'trajectory_live.tum', 'keyframes.tum', 'graph.json', 'map.pcd', 'map.pgm', 'map.yaml', 'floor_plan.dxf', 'floor_plan.png',
             'floor_plan.svg', 'decisions.csv', 'params.yaml']


def program(name):
    return roslib.packages.find_node('sgraph_slam', name)[0]


def read_tum(path):
    with open(path, encoding='ascii') as file:
        return [[float(word) for word in line.split()] for line in file if line.strip() and not line.startswith('#')]


def angle_between(a, b):
    """Degrees between two quaternions x y z w."""
    return math.degrees(2 * math.acos(min(1.0, abs(sum(x * y for x, y in zip(a, b))))))


class TransformLog:
    """When each transform was received, by its two frames: (simulated time, stamp)."""

    def __init__(self):
        self.lock = threading.Lock()
        self.entries = {}
        self.subscriber = rospy.Subscriber('/tf', TFMessage, self.take, queue_size=1000)

    def take(self, message):
        with self.lock:
            for transform in message.transforms:
                key = (transform.header.frame_id, transform.child_frame_id)
                self.entries.setdefault(key, []).append((rospy.get_rostime().to_sec(), transform.header.stamp.to_sec()))

    def of(self, parent, child):
        with self.lock:
            return list(self.entries.get((parent, child), []))


class Play(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix='sgraph_play_')
        world = os.path.join(roslib.packages.get_pkg_dir('sgraph_slam'), 'worlds', 'demo.yaml')
        subprocess.run([program('simulate'), world, cls.folder.name, f'--duration={SECONDS}', '--quiet'], check=True)
        cls.bag = os.path.join(cls.folder.name, 'data.bag')
        cls.out = os.path.join(cls.folder.name, 'live')

        cls.transforms = TransformLog()
        cls.buffer = tf2_ros.Buffer(rospy.Duration(1000))
        cls.listener = tf2_ros.TransformListener(cls.buffer)
        cls.diagnostics = Diagnostics()
        kinds = {'odom': Odometry, 'keyframes': Keyframe, 'planes': PlaneSegments, 'graph': SceneGraph, 'markers': MarkerArray, 'path': Path,
                 'map_points': PointCloud2, 'floor_plan': OccupancyGrid, 'deskewed_points': PointCloud2, 'segmented_points': PointCloud2}
        cls.topics = {name: Recorder('/sgraph_slam/' + name, kind) for name, kind in kinds.items()}
        command = ['roslaunch', 'sgraph_slam', 'play.launch', f'bag:={cls.bag}', f'out:={cls.out}', 'scan_queue:=1000', 'stay:=true']
        cls.launch = subprocess.Popen(command)
        saved = os.path.join(cls.out, 'params.yaml')  # written last
        assert wait_for(lambda: os.path.exists(saved) or cls.launch.poll() is not None, 300), 'play.launch saved nothing'
        assert cls.launch.poll() is None, 'play.launch ended early'

    @classmethod
    def tearDownClass(cls):
        if cls.launch.poll() is None:
            cls.launch.send_signal(signal.SIGINT)
            cls.launch.wait(timeout=LIMIT)
        cls.folder.cleanup()

    def last(self, topic):
        self.assertTrue(wait_for(lambda: self.topics[topic].messages), f'nothing on {topic}')
        return self.topics[topic].last

    def stamps_of(self, topic):
        return [message.header.stamp.to_sec() for message in self.topics[topic].messages]

    def test_1_nothing_was_dropped(self):
        self.assertTrue(wait_for(lambda: len(self.topics['odom'].messages) >= 10 * SECONDS), f"only {self.stamps_of('odom')}")
        self.assertEqual(len(self.topics['odom'].messages), 10 * SECONDS)
        self.assertTrue(wait_for(lambda: self.diagnostics.value('odometry', 'processed') == str(10 * SECONDS)))
        self.assertTrue(wait_for(lambda: self.diagnostics.value('mapping', 'keyframes') is not None))

    def test_2_map_to_odom_comes_at_a_steady_rate(self):
        self.assertTrue(wait_for(lambda: len(self.transforms.of('odom', 'base_link')) >= 10 * SECONDS))
        self.assertEqual(len(self.transforms.of('odom', 'base_link')), 10 * SECONDS)
        entries = self.transforms.of('map', 'odom')
        stamps = [stamp for _, stamp in entries]
        self.assertEqual(stamps, sorted(set(stamps)), 'stamps repeat or go back')
        rate = (len(stamps) - 1) / (stamps[-1] - stamps[0])
        self.assertGreater(rate, 15)  # 20 wanted; a busy machine delays some
        self.assertLess(rate, 21)

    def test_3_the_robot_can_be_placed_in_the_map_at_every_scan(self):
        for message in self.topics['odom'].messages[2:-1]:
            self.buffer.lookup_transform('map', 'base_link', message.header.stamp)
        self.buffer.lookup_transform('base_link', 'velodyne', rospy.Time(0))

    def test_4_topics(self):
        self.assertTrue(wait_for(lambda: self.stamps_of('planes') == self.stamps_of('keyframes')))
        keyframes = self.topics['keyframes'].messages
        self.assertEqual([message.id for message in keyframes], list(range(len(keyframes))))
        self.assertGreaterEqual(len(keyframes), 5)
        self.assertTrue(wait_for(lambda: [k.id for k in self.last('graph').keyframes] == [k.id for k in keyframes]))
        graph = self.last('graph')
        self.assertGreaterEqual(len(graph.planes), 8)
        self.assertTrue(wait_for(lambda: len(self.last('path').poses) == 10 * SECONDS))
        self.assertEqual(self.last('map_points').header.frame_id, 'map')
        self.assertGreater(self.last('map_points').width, 5000)
        self.assertEqual(set(read_points(self.last('segmented_points'))), {'x', 'y', 'z', 'rgb'})
        grid = self.last('floor_plan')
        self.assertEqual(len(grid.data), grid.info.width * grid.info.height)
        self.assertTrue({0, 100} <= set(grid.data))
        drawn = {marker.ns for marker in self.last('markers').markers}
        self.assertTrue({'keyframes', 'keyframe_edges', 'planes', 'plane_outlines', 'observations'} <= drawn, drawn)

    def test_5_saved_files(self):
        self.assertEqual(sorted(name for name in os.listdir(self.out) if not name.startswith('map.sgmap')), sorted(MAP_FILES))
        self.assertIn('map.sgmap', os.listdir(self.out), 'the map file is written while mapping')
        self.assertEqual(len(read_tum(os.path.join(self.out, 'trajectory.tum'))), 10 * SECONDS)
        self.assertEqual(len(read_tum(os.path.join(self.out, 'trajectory_live.tum'))), 10 * SECONDS)
        with open(os.path.join(self.out, 'graph.json'), encoding='utf-8') as file:
            graph = json.load(file)
        self.assertEqual([k['id'] for k in graph['keyframes']], [k.id for k in self.last('graph').keyframes])

    def test_6_live_and_offline_agree(self):
        offline = os.path.join(self.folder.name, 'offline')
        subprocess.run([program('run_bag'), self.bag, '--out', offline, '--quiet'], check=True)
        ours, theirs = (read_tum(os.path.join(folder, 'keyframes.tum')) for folder in (self.out, offline))
        self.assertEqual([row[0] for row in ours], [row[0] for row in theirs])
        for live, other in zip(ours, theirs):
            self.assertLess(math.dist(live[1:4], other[1:4]), 0.001)
            self.assertLess(angle_between(live[4:], other[4:]), 0.01)

    def test_7_services(self):
        response = rospy.ServiceProxy('/sgraph_slam/save', SaveMap)('copy/of_it')
        self.assertTrue(response.success, response.message)
        self.assertEqual(sorted(os.listdir(os.path.join(self.out, 'copy/of_it'))), sorted(MAP_FILES))
        self.assertFalse(rospy.ServiceProxy('/sgraph_slam/save', SaveMap)('../elsewhere').success)
        self.assertFalse(rospy.ServiceProxy('/sgraph_slam/load', LoadMap)('../elsewhere').success)
        self.assertTrue(rospy.ServiceProxy('/sgraph_slam/optimize', Trigger)().success)
        self.assertTrue(rospy.ServiceProxy('/sgraph_slam/reset', Trigger)().success)
        self.assertTrue(wait_for(lambda: not self.last('graph').keyframes))
        response = rospy.ServiceProxy('/sgraph_slam/save', SaveMap)('empty')
        self.assertFalse(response.success)
        self.assertIn('no map', response.message)

    def test_8_ends_cleanly(self):
        self.launch.send_signal(signal.SIGINT)
        self.assertEqual(self.launch.wait(timeout=LIMIT), 0)

    def play(self, bag):
        """What a launch that can't succeed prints before it ends by itself."""
        command = ['roslaunch', 'sgraph_slam', 'play.launch', f'bag:={bag}', 'namespace:=other']
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LIMIT, check=False)
        return run.stdout.decode()

    def test_9_bags_that_are_no_good(self):
        self.assertIn('No such file', self.play('/no/such.bag'))
        self.assertIn('bag', self.play(os.path.abspath(__file__)))


if __name__ == '__main__':
    import rostest
    rospy.init_node('play_test')
    rostest.rosrun('sgraph_slam', 'play', Play, sys.argv)
