# A robot's image: the Debian package, built from these sources, on a bare Debian 12.
#   docker build -t sgraph_slam .
#   docker run --rm --network host sgraph_slam roslaunch sgraph_slam slam.launch points_topic:=/velodyne_points
#   docker run --rm -v "$PWD:/data" sgraph_slam rosrun sgraph_slam run_bag /data/my.bag --out /data/map
FROM debian:bookworm AS build
COPY . /src/sgraph_slam
RUN /src/sgraph_slam/scripts/package /package

FROM debian:bookworm
COPY --from=build /package /package
RUN apt-get update -q \
  && DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends /package/*.deb \
  && rm -rf /var/lib/apt/lists/* /package
ENV ROSCONSOLE_STDOUT_LINE_BUFFERED=1
STOPSIGNAL SIGINT
CMD ["roslaunch", "sgraph_slam", "slam.launch"]
