#include "sgraph_slam/core/eval/place_quality.hpp"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "polygon.hpp"

namespace sgraph {
namespace {

using nlohmann::json;

class Geos {
 public:
  Geos() : context_(GEOS_init_r()) {}
  ~Geos() { GEOS_finish_r(context_); }
  Geos(const Geos&) = delete;
  Geos& operator=(const Geos&) = delete;

  struct Deleter {
    GEOSContextHandle_t context;
    void operator()(GEOSGeometry* geometry) const { GEOSGeom_destroy_r(context, geometry); }
  };
  using Geometry = std::unique_ptr<GEOSGeometry, Deleter>;

  // An outline that crosses itself is mended, so that a bad one costs its own score only.
  [[nodiscard]] Geometry geometry_of(const FloorArea& area) const {
    if (area.outline.size() < 3) return own(GEOSGeom_createEmptyPolygon_r(context_));
    std::vector<GEOSGeometry*> holes;
    for (const Polygon& hole : area.holes) {
      if (hole.size() >= 3) holes.push_back(ring(hole));
    }
    Geometry polygon = own(GEOSGeom_createPolygon_r(context_, ring(area.outline), holes.data(), static_cast<unsigned>(holes.size())));
    return GEOSisValid_r(context_, polygon.get()) == 1 ? std::move(polygon) : own(GEOSMakeValid_r(context_, polygon.get()));
  }

  [[nodiscard]] double area(const Geometry& geometry) const {
    double value = 0;
    GEOSArea_r(context_, geometry.get(), &value);
    return value;
  }

  [[nodiscard]] double common(const Geometry& a, const Geometry& b) const { return area(own(GEOSIntersection_r(context_, a.get(), b.get()))); }

 private:
  [[nodiscard]] Geometry own(GEOSGeometry* geometry) const {
    if (geometry == nullptr) throw std::runtime_error("GEOS can't compare the outlines of two places");
    return {geometry, Deleter{context_}};
  }

  [[nodiscard]] GEOSGeometry* ring(const Polygon& points) const {
    GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(context_, static_cast<unsigned>(points.size() + 1), 2);
    for (unsigned i = 0; i <= points.size(); ++i)
      GEOSCoordSeq_setXY_r(context_, sequence, i, points[i % points.size()].x(), points[i % points.size()].y());
    return GEOSGeom_createLinearRing_r(context_, sequence);
  }

  GEOSContextHandle_t context_;
};

Polygon polygon_from(const json& j) {
  Polygon polygon;
  for (const json& corner : j) polygon.emplace_back(corner.at(0).get<double>(), corner.at(1).get<double>());
  if (polygon.size() > 3 && (polygon.front() - polygon.back()).norm() < 1e-9) polygon.pop_back();  // closed ones repeat the first corner
  return polygon;
}

FloorArea area_from(const json& j) {
  FloorArea area{polygon_from(j.at("polygon")), {}};
  for (const json& hole : j.value("holes", json::array())) area.holes.push_back(polygon_from(hole));
  return area;
}

// A number as an id; names by their place in the list.
long long id_of(const json& j, std::size_t index) {
  return j.contains("id") && j.at("id").is_number() ? j.at("id").get<long long>() : static_cast<long long>(index);
}

std::string name_of(const json& j, std::size_t index) {
  if (!j.contains("id")) return std::to_string(index);
  return j.at("id").is_string() ? j.at("id").get<std::string>() : j.at("id").dump();
}

void add_mapped(const json& graph, const char* key, const char* kind, std::vector<MappedPlace>& places) {
  const json& list = graph.contains(key) ? graph.at(key) : json::array();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& j = list[i];
    MappedPlace place;
    place.id = id_of(j, i);
    place.kind = j.value("kind", kind);
    const json center = j.value("center", json::array({0.0, 0.0}));
    if (j.contains("polygon") && j.at("polygon").size() >= 3) {
      place.area = area_from(j);
      place.z_known = graph.contains("storeys") && center.size() > 2;
    } else {
      const std::vector<double> width = j.at("width").get<std::vector<double>>();
      const Eigen::Vector2d sides =
          j.contains("length") ? Eigen::Vector2d(j.at("length").get<double>(), width.at(0)) : Eigen::Vector2d(width.at(0), width.at(1));
      place.area.outline = rectangle({center.at(0).get<double>(), center.at(1).get<double>()}, sides, j.at("yaw").get<double>());
    }
    place.z = center.size() > 2 ? center.at(2).get<double>() : 0.0;
    if (j.contains("storey") && j.at("storey").is_number()) place.storey = j.at("storey").get<long long>();
    places.push_back(place);
  }
}

json parsed(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  return json::parse(in);
}

Eigen::Vector3d position_from(const json& j) {
  const json& p = j.at("position");
  return {p.at(0).get<double>(), p.at(1).get<double>(), p.size() > 2 ? p.at(2).get<double>() : 0.0};
}

FloorArea moved(const FloorArea& area, const Pose& T_truth_map, double z) {
  FloorArea result = area;
  const auto move = [&](Polygon& polygon) {
    for (Eigen::Vector2d& p : polygon) p = (T_truth_map * Eigen::Vector3d(p.x(), p.y(), z)).head<2>();
  };
  move(result.outline);
  for (Polygon& hole : result.holes) move(hole);
  return result;
}

bool same_level(double z, bool known, const TruePlace& truth) {
  constexpr double lenience = 0.5;  // [m]
  if (!known || truth.height <= 0) return true;
  return z > truth.z - lenience && z < truth.z + truth.height + lenience;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

}  // namespace

MappedPlaces read_mapped_places(const std::string& path) {
  try {
    const json graph = parsed(path);
    MappedPlaces result;
    if (graph.contains("places")) {
      add_mapped(graph, "places", "room", result.places);
    } else {
      add_mapped(graph, "rooms", "room", result.places);
      add_mapped(graph, "corridors", "corridor", result.places);
    }
    result.has_doors = graph.contains("doors");
    const json doors = graph.value("doors", json::array());
    for (std::size_t i = 0; i < doors.size(); ++i) {
      const json& j = doors[i];
      result.doors.push_back({id_of(j, i), position_from(j), j.at("width").get<double>(), j.value("height", 0.0)});
    }
    return result;
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

TruePlaces read_true_places(const std::string& path) {
  try {
    const json truth = parsed(path);
    TruePlaces result;
    const auto add = [&](const char* key, const char* kind, bool entered) {
      const json list = truth.value(key, json::array());
      for (std::size_t i = 0; i < list.size(); ++i) {
        const json& j = list[i];
        result.places.push_back(
            {name_of(j, i), j.value("kind", kind), area_from(j), j.value("z", 0.0), j.value("height", 0.0), j.value("entered", entered)});
      }
    };
    if (truth.contains("places")) {
      add("places", "room", true);
    } else {
      add("rooms", "room", true);
      add("corridors", "corridor", true);
      add("other_rooms", "room", false);
      add("other_corridors", "corridor", false);
    }
    result.has_doors = truth.contains("doors");
    const json doors = truth.value("doors", json::array());
    for (std::size_t i = 0; i < doors.size(); ++i) {
      const json& j = doors[i];
      result.doors.push_back({name_of(j, i), position_from(j), j.at("width").get<double>(), j.value("height", 0.0), j.value("wanted", true)});
    }
    return result;
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

double common_area(const FloorArea& a, const FloorArea& b) {
  const Geos geos;
  return geos.common(geos.geometry_of(a), geos.geometry_of(b));
}

double area_of(const FloorArea& area) {
  const Geos geos;
  return geos.area(geos.geometry_of(area));
}

double PlaceQuality::segmentation() const {
  std::vector<double> values;
  for (const QualityMatch& match : matches) values.push_back(match.iou);
  return mean(values);
}

double PlaceQuality::recognition() const {
  const double hits = static_cast<double>(matches.size());
  const double all = hits + 0.5 * static_cast<double>(missed.size() + invented.size());
  return all == 0 ? 1 : hits / all;
}

PlaceQuality score_places(const std::vector<MappedPlace>& found, const std::vector<TruePlace>& truth, const Pose& T_truth_map) {
  struct Pair {
    double iou;
    std::size_t found;
    std::size_t truth;
  };
  const Geos geos;
  std::vector<Geos::Geometry> true_areas;
  for (const TruePlace& t : truth) true_areas.push_back(geos.geometry_of(t.area));
  std::vector<Pair> pairs;
  std::vector<double> best_of_found(found.size(), 0);
  std::vector<double> best_of_truth(truth.size(), 0);
  std::vector<double> elsewhere(found.size(), 0);  // share of a found place in places that the path did not enter
  for (std::size_t f = 0; f < found.size(); ++f) {
    const Geos::Geometry area = geos.geometry_of(moved(found[f].area, T_truth_map, found[f].z));
    const double size = geos.area(area);
    const double z = (T_truth_map * Eigen::Vector3d(found[f].area.outline.front().x(), found[f].area.outline.front().y(), found[f].z)).z();
    for (std::size_t t = 0; t < truth.size(); ++t) {
      if (!same_level(z, found[f].z_known, truth[t])) continue;
      const double common = geos.common(area, true_areas[t]);
      const double iou = common / std::max(1e-9, size + geos.area(true_areas[t]) - common);
      best_of_found[f] = std::max(best_of_found[f], iou);
      best_of_truth[t] = std::max(best_of_truth[t], iou);
      if (!truth[t].entered && size > 0) elsewhere[f] += common / size;
      if (iou >= 0.5) pairs.push_back({iou, f, t});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.iou > b.iou; });
  PlaceQuality result;
  std::set<std::size_t> counted;  // found places whose true one was entered
  std::set<std::size_t> used_found;
  std::set<std::size_t> used_truth;
  for (const Pair& pair : pairs) {
    if (used_found.count(pair.found) || used_truth.count(pair.truth)) continue;
    used_found.insert(pair.found);
    used_truth.insert(pair.truth);
    if (!truth[pair.truth].entered) continue;
    counted.insert(pair.found);
    result.matches.push_back({truth[pair.truth].name, found[pair.found].id, pair.iou});
  }
  std::vector<double> of_truths;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (!truth[t].entered) continue;
    ++result.truths;
    of_truths.push_back(best_of_truth[t]);
    if (!used_truth.count(t)) result.missed.push_back(truth[t].name);
  }
  std::vector<double> of_found;
  for (std::size_t f = 0; f < found.size(); ++f) {
    const bool matched = used_found.count(f) != 0;
    if (!counted.count(f) && (matched || elsewhere[f] > 0.5)) continue;
    ++result.estimates;
    of_found.push_back(best_of_found[f]);
    if (!matched) result.invented.push_back(found[f].id);
  }
  result.iou_of_truths = mean(of_truths);
  result.iou_of_found = mean(of_found);
  return result;
}

DoorQuality score_doors(const std::vector<MappedDoor>& found, const std::vector<TrueDoor>& truth, const Pose& T_truth_map) {
  constexpr double reach = 0.5;         // [m]
  constexpr double storey_reach = 1.5;  // [m]
  struct Pair {
    double distance;
    std::size_t found;
    std::size_t truth;
  };
  std::vector<Pair> pairs;
  for (std::size_t f = 0; f < found.size(); ++f) {
    const Eigen::Vector3d p = T_truth_map * found[f].position;
    for (std::size_t t = 0; t < truth.size(); ++t) {
      const double distance = (p - truth[t].position).head<2>().norm();
      if (distance < reach && std::abs(p.z() - truth[t].position.z()) < storey_reach) pairs.push_back({distance, f, t});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  DoorQuality result;
  result.truths = static_cast<int>(std::count_if(truth.begin(), truth.end(), [](const TrueDoor& t) { return t.wanted; }));
  result.estimates = static_cast<int>(found.size());
  std::set<std::size_t> used_found;
  std::set<std::size_t> used_truth;
  for (const Pair& pair : pairs) {
    if (used_found.count(pair.found) || used_truth.count(pair.truth)) continue;
    used_found.insert(pair.found);
    used_truth.insert(pair.truth);
    const TrueDoor& t = truth[pair.truth];
    if (!t.wanted) {
      --result.estimates;
      continue;
    }
    result.position_errors.push_back(pair.distance);
    result.width_errors.push_back(found[pair.found].width - t.width);
    if (found[pair.found].height > 0 && t.height > 0) result.height_errors.push_back(found[pair.found].height - t.height);
  }
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (truth[t].wanted && !used_truth.count(t)) result.missed.push_back(truth[t].name);
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (!used_found.count(f)) result.invented.push_back(found[f].id);
  }
  return result;
}

}  // namespace sgraph
