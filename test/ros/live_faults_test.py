#!/usr/bin/python3
"""What goes wrong around a running robot: the node killed and started again, a clock that jumps or never comes, transforms that come late, a recording
that is played twice, too many points, too few scans, subscribers that never read, a disk that is full, a master that is gone. Whatever happens, the
node goes on mapping, says in diagnostics what is wrong, and ends with exit status 0 when it is asked to."""
import os
import resource
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rosgraph
import roslib.packages
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from sgraph_slam.msg import OdometryStatus, SceneGraph
from sgraph_slam.srv import SaveMap
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from support import LIMIT, Diagnostics, Recorder, box_points, cloud_message, wait_for

MOUNT = '0.15 0 0.25 0 0 0'

# Scans until one is mapped, then a service.
NEW_DRIVER = """
import rospy
from sensor_msgs.msg import PointCloud2
from sgraph_slam.msg import OdometryStatus
from std_srvs.srv import Trigger
from support import Recorder, box_points, cloud_message, wait_for
rospy.init_node('driver')
status = Recorder('/gone/odometry_status', OdometryStatus)
publisher = rospy.Publisher('/gone/points', PointCloud2, queue_size=10)
points, ring = box_points(steps=450)
for i in range(60):
    publisher.publish(cloud_message(rospy.Time.from_sec(100 + 0.1 * i), points, ring))
    if wait_for(lambda: any(message.accepted for message in status.messages), 1):
        raise SystemExit(0 if rospy.ServiceProxy('/gone/odometry/finish', Trigger)().success else 2)
raise SystemExit(1)
"""


class Node:
    """One sgraph_slam_node in a namespace of its own, fed and watched by the test."""

    def __init__(self, name, mount=MOUNT, **settings):
        self.name = name
        rospy.set_param(f'/{name}/config/ros', {'base_to_lidar': mount, **settings})
        self.status = Recorder(f'/{name}/odometry_status', OdometryStatus)
        self.graph = Recorder(f'/{name}/graph', SceneGraph)
        self.publisher = rospy.Publisher(f'/{name}/points', PointCloud2, queue_size=100)
        self.process = None

    def start(self, **options):
        command = [roslib.packages.find_node('sgraph_slam', 'sgraph_slam_node')[0], f'__ns:=/{self.name}', '__name:=slam']
        self.process = subprocess.Popen(command, **options)
        return self

    def started(self):
        self.start()
        assert wait_for(self.connected), f'{self.name} did not start'
        return self

    def connected(self):
        return self.publisher.get_num_connections() > 0 and self.status.subscriber.get_num_connections() > 0

    def send(self, seconds, points=None, **options):
        points, ring = box_points(steps=450) if points is None else points
        self.publisher.publish(cloud_message(rospy.Time.from_sec(seconds), points, ring, **options))

    def accepted(self):
        return [message.header.stamp.to_sec() for message in self.status.messages if message.accepted]

    def maps(self, seconds, limit=LIMIT, **options):
        """True when a scan of that stamp or later is accepted. As from a LiDAR, others follow it: one that jumps ahead is believed once they agree."""
        for i in range(int(limit)):
            self.send(seconds + 0.1 * i, **options)
            if wait_for(lambda: any(stamp > seconds - 1e-6 for stamp in self.accepted()), 1):
                return True
        return False

    def service(self, name):
        return rospy.ServiceProxy(f'/{self.name}/{name}', Trigger)()

    def stop(self, number=signal.SIGINT):
        """Exit status and seconds."""
        begin = time.monotonic()
        self.process.send_signal(number)
        status = self.process.wait(timeout=LIMIT)
        return status, time.monotonic() - begin


class LiveFaults(unittest.TestCase):
    slowest = 0.0

    @classmethod
    def setUpClass(cls):
        cls.diagnostics = Diagnostics()
        cls.nodes = []

    @classmethod
    def tearDownClass(cls):
        print(f'slowest stop: {cls.slowest:.2f} s')

    def tearDown(self):
        for node in self.nodes:
            if node.process and node.process.poll() is None:
                node.process.kill()
                node.process.wait()
        self.nodes.clear()

    @staticmethod
    def registered(master, node):
        """What a master knows of a node: the names of what it publishes, listens to and serves."""
        return [{name for name, nodes in kind if node in nodes} for kind in master.getSystemState()]

    def node(self, name, **settings):
        node = Node(name, **settings)
        self.nodes.append(node)
        return node

    def ends_well(self, node, number=signal.SIGINT):
        status, seconds = node.stop(number)
        LiveFaults.slowest = max(LiveFaults.slowest, seconds)
        self.assertEqual(status, 0, f'{signal.Signals(number).name} ended {node.name} with exit status {status}')

    def test_01_ends_with_status_0_at_any_moment(self):
        """From before it has found the master to the middle of its work."""
        for i, delay in enumerate([0.3, 0.5, 0.7, 1.0, 1.5, 2.5]):
            for number in (signal.SIGINT, signal.SIGTERM):
                node = self.node(f'stop_{i}_{number}').start()
                end = time.monotonic() + delay
                stamp = 100.0
                while time.monotonic() < end:
                    if node.connected():
                        node.send(stamp)
                        stamp += 0.1
                    time.sleep(0.02)
                self.ends_well(node, number)

    def test_02_killed_and_started_again(self):
        node = self.node('killed').started()
        self.assertTrue(node.maps(100) and node.maps(100.1))
        node.process.kill()
        node.process.wait()
        self.assertTrue(wait_for(lambda: not node.connected()))
        node.started()
        self.assertTrue(node.maps(110) and node.maps(110.1))
        self.ends_well(node)

    def test_03_transform_missing_for_seconds(self):
        node = self.node('late', mount='').started()
        for i in range(30):
            node.send(100 + 0.1 * i)
        self.assertTrue(wait_for(lambda: self.diagnostics.has_said('late/odometry', DiagnosticStatus.ERROR, 'no transform')))
        self.assertEqual(node.accepted(), [])
        import geometry_msgs.msg
        import tf2_ros
        transform = geometry_msgs.msg.TransformStamped()
        transform.header.frame_id, transform.child_frame_id = 'base_link', 'velodyne'
        transform.transform.rotation.w = 1
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(transform)
        self.assertTrue(node.maps(110))
        self.ends_well(node)

    def test_04_a_recording_played_twice(self):
        node = self.node('looped').started()
        for _ in range(2):
            before = len(node.accepted())
            for i in range(5):
                node.send(100 + i)
                self.assertTrue(wait_for(lambda n=before + i: len(node.accepted()) > n))
        self.assertTrue(wait_for(lambda: self.diagnostics.has_said('looped/odometry', DiagnosticStatus.ERROR, 'a new recording begins')))
        self.assertTrue(node.service('odometry/finish').success)
        self.assertTrue(wait_for(lambda: node.graph.last and node.graph.last.keyframes))
        self.ends_well(node)

    def test_05_ten_times_too_many_points(self):
        node = self.node('many').started()
        points, ring = box_points(steps=9000, rings=32)
        for i in range(5):
            node.send(100 + 0.1 * i, (points, ring))
        self.assertTrue(wait_for(lambda: node.accepted()))
        self.assertTrue(node.maps(101, points=(points, ring)))
        self.ends_well(node)

    def test_06_one_scan_a_second(self):
        node = self.node('slow').started()
        for i in range(5):
            node.send(100 + i)
            time.sleep(0.2)
        self.assertTrue(wait_for(lambda: len(node.accepted()) >= 4), node.accepted())
        self.ends_well(node)

    def test_07_subscribers_that_never_read(self):
        node = self.node('deaf').started()
        sockets = [never_reading_subscriber(f'/deaf/{topic}', kind) for topic, kind in
                   [('deskewed_points', 'sensor_msgs/PointCloud2'), ('filtered_points', 'sensor_msgs/PointCloud2'), ('markers', 'visualization_msgs/MarkerArray')]]
        memory = []
        for i in range(120):
            node.send(100 + 0.1 * i)
            self.assertTrue(wait_for(lambda n=i: len(node.accepted()) > n))
            memory.append(resident_mib(node.process.pid))
        self.assertLess(memory[-1] - memory[60], 100, 'memory grows with what is not read [MiB]')
        self.ends_well(node)
        for connection in sockets:
            connection.close()

    def test_08_full_disk(self):
        """Files can't grow: what is saved fails with the reason, mapping goes on, and what was there stays."""
        def small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, 'ROS_LOG_DIR': folder}
            node = self.node('full', map_directory=folder).start(preexec_fn=small_files, env=environment)
            self.assertTrue(wait_for(node.connected))
            for i in range(3):
                self.assertTrue(node.maps(100 + i))
            self.assertTrue(node.service('odometry/finish').success)
            self.assertTrue(wait_for(lambda: node.graph.last and node.graph.last.keyframes))
            response = rospy.ServiceProxy('/full/save', SaveMap)('map')
            self.assertFalse(response.success)
            self.assertIn('map', response.message)
            self.assertTrue(node.maps(110))
            self.ends_well(node)

    def test_09_exceptional_stamps(self):
        node = self.node('stamps').started()
        self.assertTrue(node.maps(100))
        node.send(0)
        node.send(100 + 3e8)
        self.assertTrue(node.maps(100.2) or node.maps(100.4))
        self.ends_well(node)

    def test_10_master_gone_and_back(self):
        """Without a master what is connected stays connected. One that is started again finds the node: a new driver is mapped, services answer. In the
        end there is none again, and the node can still be stopped."""
        port = free_port()
        environment = {**os.environ, 'ROS_MASTER_URI': f'http://127.0.0.1:{port}'}
        other = rosgraph.Master('/test', master_uri=environment['ROS_MASTER_URI'])

        def start_master():
            master = subprocess.Popen(['rosmaster', '--core', '-p', str(port)], env=environment, stdout=subprocess.DEVNULL)
            self.assertTrue(wait_for(lambda: rosgraph.is_master_online(environment['ROS_MASTER_URI'])))
            return master

        master = start_master()
        try:
            other.setParam('/gone/config/ros/base_to_lidar', MOUNT)
            command = [roslib.packages.find_node('sgraph_slam', 'sgraph_slam_node')[0], '__ns:=/gone', '__name:=slam']
            process = subprocess.Popen(command, env=environment)
            # The last one that the node asks for; the rest of its start takes no time.
            self.assertTrue(wait_for(lambda: '/gone/packets' in dict(other.getSystemState()[1])))
            time.sleep(1)
            of_node = self.registered(other, '/gone/slam')
            self.assertGreater(min(len(kind) for kind in of_node), 8)
            master.kill()
            master.wait()
            time.sleep(2)
            self.assertIsNone(process.poll(), 'the node ended with the master')

            master = start_master()
            self.assertTrue(wait_for(lambda: self.registered(other, '/gone/slam') == of_node), 'what the node has is not registered again')
            # In a process of its own, since a process has one master.
            driver = subprocess.run([sys.executable, '-c', NEW_DRIVER], env=environment, cwd=os.path.dirname(os.path.abspath(__file__)), timeout=LIMIT)
            self.assertEqual(driver.returncode, 0, 'a driver that was started with the new master is not mapped')
        finally:
            master.kill()
            master.wait()
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=LIMIT), 0)

    def test_11_simulated_time_without_a_clock_and_with_jumps(self):
        """Last: /use_sim_time counts for every node of this master. The test itself runs on real time."""
        rospy.set_param('/use_sim_time', True)
        node = self.node('clock').started()
        self.assertTrue(wait_for(lambda: self.diagnostics.has_said('clock/odometry', DiagnosticStatus.WARN, 'no clock')))
        self.assertTrue(node.maps(100), 'scans carry their own time; mapping needs no clock')

        transforms = Recorder('/tf', TFMessage)

        def corrections():
            return [t.header.stamp.to_sec() for m in list(transforms.messages) for t in m.transforms if t.header.frame_id == 'map']

        clock = rospy.Publisher('/clock', Clock, queue_size=100)
        now, jumps = [100.0], []
        running = threading.Event()
        running.set()

        def tick():
            while running.is_set():
                clock.publish(rospy.Time.from_sec(now[0]))
                now[0] = jumps.pop() if jumps else now[0] + 0.02
                time.sleep(0.02)

        ticker = threading.Thread(target=tick)
        ticker.start()
        try:
            self.assertTrue(wait_for(corrections), 'map -> odom never came')
            for jump in (500.0, 50.0, 300.0, 10.0):
                jumps.append(jump)
                self.assertTrue(wait_for(lambda: not jumps))
                self.assertTrue(node.maps(jump + 0.1), f'no scan is mapped after the jump to {jump}')
                # A scan that overtakes the clock's jump is dated by the old clock; the next one mends that, as it does on a robot.
                self.assertTrue(node.maps(jump + 0.2))
                self.assertTrue(wait_for(lambda: any(abs(stamp - now[0]) < 5 for stamp in corrections()[-5:])), f'map -> odom stopped after {jump}')
            self.ends_well(node)
        finally:
            running.clear()
            ticker.join()


def free_port():
    with socket.socket() as s:
        s.bind(('127.0.0.1', 0))
        return s.getsockname()[1]


def resident_mib(pid):
    with open(f'/proc/{pid}/status', encoding='ascii') as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith('VmRSS'))


def never_reading_subscriber(topic, kind):
    """Connects as a subscriber does, and then reads nothing any more: a viewer that hangs, a link that is gone."""
    master = rosgraph.Master('/never_reads')
    publishers = []
    assert wait_for(lambda: publishers.extend(dict(master.getSystemState()[0]).get(topic, [])) or publishers), f'nobody publishes {topic}'
    import xmlrpc.client
    slave = xmlrpc.client.ServerProxy(master.lookupNode(publishers[0]))
    _, _, (_, host, port) = slave.requestTopic('/never_reads', topic, [['TCPROS']])
    connection = socket.create_connection((host, port))
    fields = [b'callerid=/never_reads', b'topic=' + topic.encode(), b'type=' + kind.encode(), b'md5sum=*', b'message_definition=']
    header = b''.join(struct.pack('<I', len(field)) + field for field in fields)
    connection.sendall(struct.pack('<I', len(header)) + header)
    connection.recv(4)
    return connection


if __name__ == '__main__':
    import rostest
    rospy.init_node('live_faults_test')
    rostest.rosrun('sgraph_slam', 'live_faults', LiveFaults, sys.argv)
