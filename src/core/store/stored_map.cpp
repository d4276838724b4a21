#include "sgraph_slam/core/store/stored_map.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "bytes.hpp"
#include "database.hpp"
#include "schema.hpp"
#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/store/cloud_codec.hpp"

namespace sgraph {
namespace {

PlaneClass class_from(const std::string& word) {
  for (const PlaneClass value : {PlaneClass::x, PlaneClass::y, PlaneClass::horizontal, PlaneClass::unclassified}) {
    if (word == to_string(value)) return value;
  }
  throw std::runtime_error("an unknown class of a plane");
}

Plane plane_from(std::string_view bytes) {
  const Eigen::Vector4d v = ByteReader(bytes).matrix<4, 1>();
  if (!v.allFinite() || !(std::abs(v.head<3>().norm() - 1) < 1e-6)) throw std::runtime_error("a damaged plane");
  return {v.head<3>(), v[3]};
}

StoredSession session_from(const Statement& row) {
  StoredSession session;
  session.id = row.integer(0);
  session.source = row.text(1);
  session.sensor = row.text(2);
  session.started.nanoseconds = row.integer(3);
  session.T_base_lidar = ByteReader(row.blob(4)).pose();
  session.frame = row.text(5);
  session.parameters = row.text(6);
  session.program = row.text(7);
  session.localisation = row.text(8);
  return session;
}

constexpr const char* select_sessions =
    "SELECT id, source, sensor, started, base_lidar, frame, parameters, program, localisation FROM sessions ORDER BY id";

Keyframe keyframe_from(const Statement& row) {
  Keyframe keyframe;
  keyframe.id = {row.integer(0)};
  keyframe.stamp.nanoseconds = row.integer(2);
  keyframe.T_odom_base = ByteReader(row.blob(3)).pose();
  keyframe.covariance = ByteReader(row.blob(4)).matrix<6, 6>();
  ByteReader directions(row.blob(5));
  while (directions.left() > 0) keyframe.degenerate.emplace_back(directions.matrix<6, 1>());
  const std::string scans = decompressed(row.blob(6));
  ByteReader in(scans);
  while (in.left() > 0) {
    StampedPose scan;
    scan.stamp.nanoseconds = in.value<std::int64_t>();
    scan.pose = in.pose();
    keyframe.scans.push_back(scan);
  }
  return keyframe;
}

constexpr const char* select_keyframes = "SELECT id, session, stamp, odometry, covariance, degenerate, scans FROM keyframes ORDER BY id";

// Reads rows until there are no more; what a row holds that makes no sense ends in an error that names the table.
template <class Take>
void each(Database& database, const char* table, const std::string& sql, Take take) {
  Statement statement(database, sql);
  while (statement.step()) {
    try {
      take(statement);
    } catch (const StoreError&) {
      throw;
    } catch (const std::exception& error) {
      throw StoreError(database.path() + ": the file is damaged (" + table + " " + std::to_string(statement.integer(0)) + ": " + error.what() + ")");
    }
  }
}

void read_graph(Database& database, StoredMap& map) {
  each(database, "poses", "SELECT keyframe, pose FROM poses ORDER BY keyframe",
       [&](const Statement& row) { map.poses[{row.integer(0)}] = ByteReader(row.blob(1)).pose(); });
  each(database, "planes", "SELECT id, class, plane, covariance, view_covariance, extent FROM planes ORDER BY id", [&](const Statement& row) {
    StoredPlane& plane = map.planes[{row.integer(0)}];
    plane.id = {row.integer(0)};
    plane.plane_class = class_from(row.text(1));
    plane.plane = plane_from(row.blob(2));
    plane.covariance = ByteReader(row.blob(3)).matrix<3, 3>();
    plane.view_covariance = ByteReader(row.blob(4)).matrix<3, 3>();
    plane.extent = ByteReader(row.blob(5)).points();
  });
  each(database, "factors", "SELECT id, value FROM factors ORDER BY id",
       [&](const Statement& row) { map.factors.insert(factor_from_json(row.text(1))); });
  each(database, "merges", "SELECT merged, value FROM merges ORDER BY merged",
       [&](const Statement& row) { map.merges.insert(merge_from_json(row.text(1))); });
  each(database, "views", "SELECT factor, keyframe, extent FROM views ORDER BY factor", [&](const Statement& row) {
    map.views[{row.integer(0)}] = {{row.integer(0)}, {row.integer(1)}, ByteReader(row.blob(2)).points()};
  });
}

void read_sightings(Database& database, StoredMap& map) {
  Statement statement(database, "SELECT plane, keyframe FROM sightings ORDER BY plane, keyframe");
  while (statement.step()) map.retired[{statement.integer(0)}].insert({statement.integer(1)});
}

void read_clouds(Database& database, StoredMap& map) {
  Statement statement(database, "SELECT keyframe, data FROM clouds ORDER BY keyframe");
  while (statement.step()) {
    const auto keyframe = map.keyframes.find({statement.integer(0)});
    if (keyframe == map.keyframes.end()) continue;
    try {
      keyframe->second.cloud = std::make_shared<const Cloud>(decode_cloud(statement.blob(1)));
    } catch (const std::exception& error) {  // the rest of the map is worth more than one cloud
      map.faults.push_back("the cloud of keyframe " + std::to_string(statement.integer(0)) + " cannot be read: " + error.what());
    }
  }
}

// Which storeys keyframes and planes are on; damaged, all are on the first.
void read_storeys(const std::string& text, StoredMap& map) {
  std::map<KeyframeId, int> keyframes;
  std::map<PlaneId, int> planes;
  try {
    const nlohmann::json storeys = nlohmann::json::parse(text);
    for (const auto& pair : storeys.at("keyframes")) keyframes[{pair.at(0).get<std::int64_t>()}] = pair.at(1).get<int>();
    for (const auto& pair : storeys.at("planes")) planes[{pair.at(0).get<std::int64_t>()}] = pair.at(1).get<int>();
  } catch (const std::exception& error) {
    map.faults.push_back(std::string("the storeys cannot be read: ") + error.what());
    return;
  }
  map.keyframe_storeys = std::move(keyframes);
  map.plane_storeys = std::move(planes);
}

// The text of the places; empty when it is damaged: they can be found again from the rest.
std::string readable_scene(std::string text, std::vector<std::string>& faults) {
  try {
    parse_graph_json(text);
    return text;
  } catch (const std::exception& error) {
    faults.push_back(std::string("the places cannot be read: ") + error.what());
    return {};
  }
}

// Views of a plane, by keyframe.
std::map<PlaneId, std::vector<const StoredView*>> views_by_plane(const StoredMap& map) {
  std::map<PlaneId, std::vector<const StoredView*>> views;
  for (const auto& [id, view] : map.views) {
    const auto factor = map.factors.find(id);
    if (factor == map.factors.end()) continue;
    for (const VariableId& variable : blocks(factor->second.data)) {
      if (const auto* plane = std::get_if<PlaneId>(&variable)) views[*plane].push_back(&view);
    }
  }
  for (auto& [id, seen] : views) {
    std::stable_sort(seen.begin(), seen.end(), [](const StoredView* a, const StoredView* b) { return a->keyframe < b->keyframe; });
  }
  return views;
}

}  // namespace

StoredMap read_map(const std::string& path, Clouds clouds) {
  Database database(path, Access::read);
  const int schema = check_schema(database);
  database.execute("BEGIN");  // one state of it, also while it is being written
  StoredMap map;
  map.path = path;
  each(database, "sessions", select_sessions, [&](const Statement& row) { map.sessions[row.integer(0)] = session_from(row); });
  each(database, "keyframes", select_keyframes, [&](const Statement& row) {
    const Keyframe keyframe = keyframe_from(row);
    map.session_of[keyframe.id] = row.integer(1);
    map.keyframes[keyframe.id] = keyframe;
  });
  read_graph(database, map);
  if (schema >= 2) read_sightings(database, map);
  each(database, "decisions", "SELECT number, keyframe, accepted, what, reason FROM decisions ORDER BY number", [&](const Statement& row) {
    map.decisions.push_back({{row.integer(1)}, row.integer(2) != 0, row.text(3), row.text(4)});
  });
  each(database, "documents", "SELECT name, value FROM documents ORDER BY name", [&](const Statement& row) {
    if (row.text(0) == "scene") map.scene = readable_scene(row.text(1), map.faults);
    if (row.text(0) == "storeys") read_storeys(row.text(1), map);
    if (row.text(0) == "next_ids") map.next_ids = nlohmann::json::parse(row.text(1)).get<std::array<std::int64_t, 4>>();
  });
  if (clouds == Clouds::all) read_clouds(database, map);
  database.execute("COMMIT");
  return map;
}

GraphSnapshot snapshot_of(const StoredMap& map) {
  GraphSnapshot snapshot = map.scene.empty() ? GraphSnapshot{} : parse_graph_json(map.scene);
  for (const auto& [id, keyframe] : map.keyframes) {
    const auto pose = map.poses.find(id);
    if (pose == map.poses.end()) continue;
    snapshot.keyframes[id] = {id, keyframe.stamp, pose->second, keyframe.T_odom_base, keyframe.scans, keyframe.cloud};
    const auto storey = map.keyframe_storeys.find(id);
    if (storey != map.keyframe_storeys.end()) snapshot.keyframes[id].storey = storey->second;
  }
  const auto views = views_by_plane(map);
  for (const auto& [id, plane] : map.planes) {
    ScenePlane& scene = snapshot.planes[id];
    scene.id = id;
    scene.plane = plane.plane;
    scene.plane_class = plane.plane_class;
    scene.covariance = plane.covariance;
    scene.extent = plane.extent;
    const auto storey = map.plane_storeys.find(id);
    if (storey != map.plane_storeys.end()) scene.storey = storey->second;
    const auto retired = map.retired.find(id);
    if (retired != map.retired.end()) scene.keyframes = retired->second;
    const auto seen = views.find(id);
    if (seen == views.end()) continue;
    for (const StoredView* view : seen->second) {
      scene.keyframes.insert(view->keyframe);
      scene.observations.push_back({view->keyframe, view->extent});
    }
  }
  std::string factors;
  for (const auto& [id, factor] : map.factors) factors += (factors.empty() ? "" : ",") + factor_to_json(id, factor);
  snapshot.factors_json = '[' + factors + ']';
  snapshot.decisions = map.decisions;
  return snapshot;
}

MapSummary summarize_map(const std::string& path) {
  Database database(path, Access::read);
  MapSummary summary;
  summary.schema = check_schema(database);
  database.execute("BEGIN");
  summary.bytes = database.number("PRAGMA page_count") * database.number("PRAGMA page_size");
  summary.keyframes = database.number("SELECT count(*) FROM keyframes");
  summary.planes = database.number("SELECT count(*) FROM planes");
  summary.factors = database.number("SELECT count(*) FROM factors");
  summary.merges = database.number("SELECT count(*) FROM merges");
  summary.points = database.number("SELECT sum(points) FROM clouds");
  summary.cloud_bytes = database.number("SELECT sum(length(data)) FROM clouds");
  std::vector<std::string> faults;  // check_map tells them
  const std::string scene = readable_scene(database.text("SELECT value FROM documents WHERE name = 'scene'"), faults);
  if (!scene.empty()) {
    const GraphSnapshot places = parse_graph_json(scene);
    summary.rooms = static_cast<std::int64_t>(places.rooms.size());
    summary.corridors = static_cast<std::int64_t>(places.corridors.size());
  }
  each(database, "sessions", select_sessions, [&](const Statement& row) { summary.sessions.push_back({session_from(row), 0, {}, 0}); });
  for (MapSummary::Session& session : summary.sessions) {
    std::optional<Eigen::Vector3d> last;
    each(database, "keyframes",
         "SELECT id, stamp, pose FROM keyframes JOIN poses ON keyframe = id WHERE session = " + std::to_string(session.session.id) + " ORDER BY id",
         [&](const Statement& row) {
           ++session.keyframes;
           session.ended.nanoseconds = row.integer(1);
           const Eigen::Vector3d at = ByteReader(row.blob(2)).pose().translation;
           if (last) session.path += (at - *last).norm();
           last = at;
         });
  }
  return summary;
}

std::vector<std::string> check_map(const std::string& path) {
  std::vector<std::string> faults;
  {
    Database database(path, Access::read);
    check_schema(database);
    Statement statement(database, "PRAGMA integrity_check(20)");
    while (statement.step()) {
      if (statement.text(0) != "ok") faults.push_back(statement.text(0));
    }
  }
  if (!faults.empty()) return faults;
  const StoredMap map = read_map(path, Clouds::all);
  faults = map.faults;
  for (const auto& [id, keyframe] : map.keyframes) {
    const std::string name = "keyframe " + std::to_string(id.value);
    if (map.poses.count(id) == 0) faults.push_back(name + " has no pose");
    if (map.sessions.count(map.session_of.at(id)) == 0) faults.push_back(name + " is of no session");
  }
  for (const auto& [id, view] : map.views) {
    if (map.keyframes.count(view.keyframe) == 0) faults.push_back("view " + std::to_string(id.value) + " is of no keyframe");
  }
  for (const auto& [id, keyframes] : map.retired) {
    for (const KeyframeId keyframe : keyframes) {
      if (map.keyframes.count(keyframe) == 0)
        faults.push_back("plane " + std::to_string(id.value) + " was seen by keyframe " + std::to_string(keyframe.value) + ", which is not there");
    }
  }
  const auto known = [&map](const VariableId& variable) {
    if (const auto* keyframe = std::get_if<KeyframeId>(&variable)) return map.poses.count(*keyframe) > 0;
    if (const auto* plane = std::get_if<PlaneId>(&variable)) return map.planes.count(*plane) > 0;
    return true;
  };
  for (const auto& [id, factor] : map.factors) {
    for (const VariableId& variable : blocks(factor.data)) {
      if (!known(variable)) faults.push_back("factor " + std::to_string(id.value) + " names " + to_string(variable) + ", which is not there");
    }
  }
  return faults;
}

}  // namespace sgraph
