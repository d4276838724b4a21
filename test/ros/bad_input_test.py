#!/usr/bin/python3
"""Input that is no good: the nodelets say so in diagnostics and go on; bad parameters stop the start with all errors listed."""
import subprocess
import sys
import unittest

import geometry_msgs.msg
import numpy as np
import roslib.packages
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2
from sgraph_slam.msg import Keyframe, OdometryStatus
from sgraph_slam.srv import LoadMap, SaveMap
from std_srvs.srv import Trigger

from support import LAYOUT, LIMIT, Diagnostics, Recorder, box_points, cloud_message, wait_for


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        for service in ['prefilter/flush', 'odometry/finish', 'plane_segmentation/flush', 'save']:
            rospy.wait_for_service('/robot/' + service, timeout=LIMIT)
        cls.points, cls.ring = box_points()
        cls.diagnostics = Diagnostics()
        cls.status = Recorder('/robot/odometry_status', OdometryStatus)
        cls.keyframes = Recorder('/robot/keyframes', Keyframe)
        cls.publisher = rospy.Publisher('/lidar/points', PointCloud2, queue_size=100)
        assert wait_for(lambda: cls.publisher.get_num_connections() > 0 and cls.status.subscriber.get_num_connections() > 0)

    def send(self, seconds, **changes):
        message = cloud_message(rospy.Time.from_sec(seconds), self.points, self.ring)
        for name, value in changes.items():
            setattr(message, name, value)
        self.publisher.publish(message)

    def expect(self, nodelet, level, text):
        self.assertTrue(wait_for(lambda: self.diagnostics.has_said(nodelet, level, text)), f'{nodelet} never said: {text}')

    def accepted(self):
        return sum(message.accepted for message in self.status.messages)

    def expect_another_scan(self, seconds):
        before = self.accepted()
        self.send(seconds)
        self.assertTrue(wait_for(lambda: self.accepted() > before), 'a good scan was not mapped any more')

    def test_1_a_missing_transform_is_named_and_scans_wait_for_it(self):
        for i in range(20):
            self.send(100 + i)
        self.expect('odometry', DiagnosticStatus.ERROR, "no transform from 'velodyne' to 'base_link'")
        self.expect('odometry', DiagnosticStatus.WARN, 'queue is full')
        self.assertEqual(self.status.messages, [])
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        transform = geometry_msgs.msg.TransformStamped()
        transform.header.frame_id, transform.child_frame_id = 'base_link', 'velodyne'
        transform.transform.translation.z = 0.25
        transform.transform.rotation.w = 1
        broadcaster.sendTransform(transform)
        # The newest of the scans that came too early are mapped now.
        self.assertTrue(wait_for(lambda: self.accepted() >= 3))
        self.assertTrue(wait_for(lambda: self.status.last.header.stamp.to_sec() == 119))

    def test_2_a_cloud_without_positions(self):
        self.publisher.publish(cloud_message(rospy.Time(120), self.points, self.ring, layout=LAYOUT[3:]))
        self.expect('prefilter', DiagnosticStatus.ERROR, 'cloud refused')
        self.expect_another_scan(121)

    def test_3_clouds_whose_sizes_make_no_sense(self):
        self.send(122, width=10 ** 6)
        self.send(122.1, point_step=3)
        self.send(122.2, data=b'')
        self.send(122.3, is_bigendian=True)
        self.assertTrue(wait_for(lambda: self.diagnostics.value('prefilter', 'scans dropped: big_endian') == '1'))
        self.assertEqual(self.diagnostics.value('prefilter', 'scans dropped: layout'), '3')
        self.expect_another_scan(123)

    def test_4_a_cloud_without_a_frame(self):
        self.publisher.publish(cloud_message(rospy.Time(124), self.points, self.ring, frame=''))
        self.expect('prefilter', DiagnosticStatus.ERROR, 'names no frame')
        self.expect_another_scan(125)

    def test_5_empty_clouds_and_points_that_are_not_numbers(self):
        self.publisher.publish(cloud_message(rospy.Time(126), self.points[:0], self.ring[:0]))
        self.expect('odometry', DiagnosticStatus.WARN, 'too few points')
        self.publisher.publish(cloud_message(rospy.Time(127), np.full_like(self.points, np.nan), self.ring))
        self.assertTrue(wait_for(lambda: any(m.header.stamp.to_sec() == 127 and not m.accepted for m in self.status.messages)))
        self.expect_another_scan(128)

    def test_6_a_scan_that_comes_twice(self):
        self.send(128)
        self.expect('odometry', DiagnosticStatus.WARN, 'stamp not after the last one')
        self.expect_another_scan(129)

    def test_7_another_lidar_on_the_topic(self):
        self.publisher.publish(cloud_message(rospy.Time(130), self.points, self.ring, frame='other'))
        self.expect('odometry', DiagnosticStatus.ERROR, "its frame is 'other'")
        self.expect_another_scan(131)

    def test_7_the_robots_odometry_is_listened_to_beside_the_lidars(self):
        publisher = rospy.Publisher('/odom', Odometry, queue_size=10)
        self.assertTrue(wait_for(lambda: publisher.get_num_connections() > 0), 'nobody listens to the robot')
        message = Odometry(child_frame_id='base_link')
        message.header.stamp, message.header.frame_id = rospy.Time(131.5), 'odom'
        message.pose.pose.position.x = float('nan')
        publisher.publish(message)
        self.expect('odometry', DiagnosticStatus.ERROR, 'robot odometry refused')
        self.expect_another_scan(132)

    def test_8_time_that_goes_back_starts_a_new_recording(self):
        self.assertTrue(wait_for(lambda: self.keyframes.messages))
        before = len(self.keyframes.messages)
        self.expect_another_scan(50)
        self.expect('odometry', DiagnosticStatus.ERROR, 'a new recording begins')
        self.expect_another_scan(50.1)
        rospy.ServiceProxy('/robot/odometry/finish', Trigger)()
        self.assertTrue(wait_for(lambda: len(self.keyframes.messages) > before))
        self.assertTrue(wait_for(lambda: self.keyframes.messages[before].id == 0))

    def test_9_paths_that_lead_out_of_the_map_directory(self):
        for service, kind in (('save', SaveMap), ('load', LoadMap)):
            for path in ('../elsewhere', '/etc', 'a/../../b'):
                response = rospy.ServiceProxy('/robot/' + service, kind)(path)
                self.assertFalse(response.success)
                self.assertIn('leads out of the map directory', response.message)

    def test_a_start_with_bad_parameters_is_refused_with_all_errors(self):
        rospy.set_param('/wrong/config', {'prefilter': {'leav': 0.1, 'min_range': 'near'}, 'odometry': {'source': 'guess'}, 'mapping': [1, 2],
                                          'ros': {'tf_rate': 1e9}})
        node = roslib.packages.find_node('sgraph_slam', 'sgraph_slam_node')[0]
        run = subprocess.run([node, '__ns:=/wrong', '__name:=wrong'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LIMIT, check=False)
        text = run.stdout.decode()
        self.assertEqual(run.returncode, 1, text)
        self.assertIn('mapping', text)

        rospy.delete_param('/wrong/config/mapping')
        run = subprocess.run([node, '__ns:=/wrong', '__name:=wrong'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LIMIT, check=False)
        text = run.stdout.decode()
        self.assertEqual(run.returncode, 1, text)
        for name in ('prefilter.leav', 'prefilter.min_range', 'odometry.source', 'ros.tf_rate'):
            self.assertIn(name, text)


if __name__ == '__main__':
    import rostest
    rospy.init_node('bad_input_test')
    rostest.rosrun('sgraph_slam', 'bad_input', BadInput, sys.argv)
