#!/usr/bin/python3
"""Another process on the other end of the wire: it feeds the nodelets by TCP and reads what they publish as ordinary messages. The nodelets run in the
robot's own manager."""
import sys
import unittest

import numpy as np
import rospy
import tf2_ros
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2, PointField
from sgraph_slam.msg import Keyframe, OdometryStatus, PlaneSegments
from std_srvs.srv import Trigger

from support import LAYOUT, LIMIT, Recorder, box_points, cloud_message, read_points, wait_for


class Wire(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        for service in ['prefilter/flush', 'odometry/finish', 'plane_segmentation/flush', 'save']:
            rospy.wait_for_service('/robot/' + service, timeout=LIMIT)
        cls.points, cls.ring = box_points()
        cls.buffer = tf2_ros.Buffer(rospy.Duration(1e6))
        cls.listener = tf2_ros.TransformListener(cls.buffer)

    def publisher(self, topic):
        publisher = rospy.Publisher(topic, PointCloud2, queue_size=100)
        self.assertTrue(wait_for(lambda: publisher.get_num_connections() > 0))
        return publisher

    def test_1_filtered_points_are_an_ordinary_cloud(self):
        filtered = Recorder('/robot/filtered_points', PointCloud2)
        deskewed = Recorder('/robot/deskewed_points', PointCloud2)
        odom = Recorder('/robot/odom', Odometry)
        publisher = self.publisher('/lidar/points')
        self.assertTrue(wait_for(lambda: min(r.subscriber.get_num_connections() for r in (filtered, deskewed, odom)) > 0))
        stamp = rospy.Time(1000, 123456789)
        publisher.publish(cloud_message(stamp, self.points, self.ring))
        self.assertTrue(wait_for(lambda: filtered.messages and deskewed.messages and odom.messages))
        for message in (filtered.last, deskewed.last, odom.last):
            self.assertEqual(message.header.stamp, stamp)  # to the nanosecond
        self.assertEqual(filtered.last.header.frame_id, 'velodyne')
        filtered.subscriber.unregister()  # or this process would count as a reader of what it publishes there next

        fields = read_points(filtered.last)
        self.assertEqual(set(fields), {'x', 'y', 'z', 'intensity', 'time', 'ring'})
        got = np.stack([fields['x'], fields['y'], fields['z']], axis=1)
        self.assertGreater(len(got), 1000)
        self.assertLessEqual(len(got), len(self.points))
        # Each is one of the points that went in, with its own ring.
        rows = {tuple(p): r for p, r in zip(self.points.tolist(), self.ring.tolist())}
        for point, ring in zip(got.tolist(), fields['ring'].tolist()):
            self.assertEqual(rows[tuple(point)], ring)

    def test_2_scans_in_an_odd_layout_go_straight_into_the_odometry(self):
        status = Recorder('/robot/odometry_status', OdometryStatus)
        planes = Recorder('/robot/planes', PlaneSegments)
        keyframes = Recorder('/robot/keyframes', Keyframe)
        publisher = self.publisher('/robot/filtered_points')
        self.assertTrue(wait_for(lambda: min(r.subscriber.get_num_connections() for r in (status, planes, keyframes)) > 0))
        odd = [('ring', PointField.UINT16), ('time', PointField.FLOAT32), ('z', PointField.FLOAT32), ('x', PointField.FLOAT32),
               ('intensity', PointField.FLOAT32), ('y', PointField.FLOAT32)]
        for layout in (odd, LAYOUT, odd):  # a layout that changes on the way
            seen = len(status.messages)
            publisher.publish(cloud_message(rospy.Time(1001 + seen, 5), self.points[::3], self.ring[::3], layout))
            self.assertTrue(wait_for(lambda: len(status.messages) > seen))
            self.assertTrue(status.last.accepted, status.last.verdict)
        self.assertEqual(status.last.status, OdometryStatus.TRACKED)
        self.assertGreater(status.last.inlier_share, 0.5)  # read right: the same room in each layout

        response = rospy.ServiceProxy('/robot/odometry/finish', Trigger)()
        self.assertTrue(response.success, response.message)
        self.assertTrue(wait_for(lambda: keyframes.messages and planes.messages))
        # Four walls and the floor or the ceiling, at their distances.
        self.assertGreaterEqual(len(planes.last.segments), 4)
        distances = [segment.d for segment in planes.last.segments]
        for wall in (4.0, 3.0):
            self.assertLess(min(abs(d - wall) for d in distances), 0.02, distances)

    def test_3_tf_holds_the_mount_and_the_chain(self):
        self.assertTrue(wait_for(lambda: self.buffer.can_transform('map', 'velodyne', rospy.Time(0))))
        mount = self.buffer.lookup_transform('base_link', 'velodyne', rospy.Time(0)).transform.translation
        self.assertEqual((mount.x, mount.y, mount.z), (0.15, 0, 0.25))


if __name__ == '__main__':
    import rostest
    rospy.init_node('wire_test')
    rostest.rosrun('sgraph_slam', 'wire', Wire, sys.argv)
