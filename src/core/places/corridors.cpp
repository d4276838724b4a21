#include "sgraph_slam/core/places/corridors.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

constexpr double side_margin = 0.25;   // a wall this near to a side of the corridor does not cut it [m]
constexpr double cut_share = 0.5;      // a wall along the inside over this share of the length cuts it
constexpr double end_share = 0.6;      // a wall across over this share of the width ends it where its sides end ...
constexpr double inner_share = 0.9;    // ... over this share where both go on behind: else it's a cabinet's side, a door leaf, a person ...
constexpr double inner_height = 0.75;  // ... and when it is so high, compared with the lower of the sides
constexpr double end_slack = 1.0;      // the robot may be this far beyond the walls' common stretch [m]

// A place as a corridor sees it: x along, y across; right wall at low y, left wall at high y.
struct Candidate {
  const Face* right;
  const Face* left;
  Interval along;
  std::array<bool, 2> closed;
  double coverage;
};

// The stretch in which a position lies, or the nearest within `slack`.
std::optional<Interval> stretch_at(const Intervals& parts, double position, double slack) {
  std::optional<Interval> best;
  double nearest = slack;
  for (const Interval& part : parts) {
    const double away = std::max({0.0, part.low - position, position - part.high});
    if (away <= nearest && (!best || away < nearest)) {
      best = part;
      nearest = away;
    }
  }
  return best;
}

// Ends the stretch at the nearest walls across it, on both sides of the position. A face looks along the corridor from the end that it closes.
void close_ends(const PlaceView& view, Interval across, double side_height, double position, Interval* along, std::array<bool, 2>* closed) {
  const Interval open = *along;
  const auto crosses = [&](const Face& face) {
    const bool inner = face.position > open.low + end_slack && face.position < open.high - end_slack;
    if (inner && face.height < inner_height * side_height) return false;
    return total_length(clip(face.span, across)) >= (inner ? inner_share : end_share) * across.length();
  };
  for (const Face& face : view.faces[low_x]) {
    if (face.position >= position || face.position <= open.low - end_slack || !crosses(face)) continue;
    along->low = (*closed)[0] ? std::max(along->low, face.position) : face.position;
    (*closed)[0] = true;
  }
  for (const Face& face : view.faces[high_x]) {
    if (face.position <= position || face.position >= open.high + end_slack || !crosses(face)) continue;
    along->high = (*closed)[1] ? std::min(along->high, face.position) : face.position;
    (*closed)[1] = true;
  }
}

bool is_cut(const PlaceView& view, const Candidate& candidate) {
  const Interval inside{candidate.right->position + side_margin, candidate.left->position - side_margin};
  for (const Side side : {low_y, high_y}) {
    for (const Face& face : view.faces[side]) {
      if (face.position <= inside.low || face.position >= inside.high) continue;
      if (total_length(clip(face.span, candidate.along)) >= cut_share * candidate.along.length()) return true;
    }
  }
  return false;
}

CorridorVerdict judge_length(const Candidate& candidate, double width, const CorridorParams& params, double ease) {
  const double length = candidate.along.length();
  if (length < ease * params.min_length || length < ease * params.min_aspect * width) return CorridorVerdict::short_;
  if (length > params.max_length) return CorridorVerdict::long_;
  if (candidate.closed[0] && candidate.closed[1] && length < ease * params.closed_aspect * width) return CorridorVerdict::room;
  return CorridorVerdict::accepted;
}

// All tests on the two walls of `candidate`; fills the rest of it.
CorridorVerdict judge(const PlaceView& view, double position, const CorridorParams& params, double slack, Candidate* candidate) {
  const double ease = 1 - slack;
  const Interval across{candidate->right->position, candidate->left->position};
  if (across.length() < ease * params.min_width || across.length() > (1 + 0.2 * slack) * params.max_width) return CorridorVerdict::no_walls;
  // Doors and crossing corridors are gaps in one wall or the other; where both walls end, the corridor ends.
  const Intervals right = coplanar_span(view.faces[low_y], across.low, params.coplanar, params.max_gap);
  const Intervals left = coplanar_span(view.faces[high_y], across.high, params.coplanar, params.max_gap);
  const auto right_stretch = stretch_at(right, position, end_slack);
  const auto left_stretch = stretch_at(left, position, end_slack);
  if (!right_stretch || !left_stretch || overlap(*right_stretch, *left_stretch) <= 0) return CorridorVerdict::uncovered;
  candidate->along = {std::max(right_stretch->low, left_stretch->low), std::min(right_stretch->high, left_stretch->high)};
  candidate->closed = {false, false};
  close_ends(view, across, std::min(candidate->right->height, candidate->left->height), position, &candidate->along, &candidate->closed);
  if (candidate->along.length() <= 0) return CorridorVerdict::short_;
  const double seen_right = side_coverage(view.faces[low_y], true, across.low, candidate->along, params.coplanar, 0);
  const double seen_left = side_coverage(view.faces[high_y], false, across.high, candidate->along, params.coplanar, 0);
  candidate->coverage = 0.5 * (seen_right + seen_left);
  if (std::min(seen_right, seen_left) < ease * params.min_coverage) return CorridorVerdict::uncovered;
  const CorridorVerdict length = judge_length(*candidate, across.length(), params, ease);
  if (length != CorridorVerdict::accepted) return length;
  return is_cut(view, *candidate) ? CorridorVerdict::cut : CorridorVerdict::accepted;
}

CorridorShape shape_of(const PlaceView& view, const std::vector<Wall>& walls, const Candidate& candidate, double reference_yaw) {
  CorridorShape shape;
  const Interval across{candidate.right->position, candidate.left->position};
  shape.walls = {walls[candidate.right->wall].id, walls[candidate.left->wall].id};
  shape.closed = candidate.closed;
  shape.coverage = candidate.coverage;
  shape.area.center = view.to_map({candidate.along.center(), across.center()});
  shape.area.size = {candidate.along.length(), across.length()};
  shape.area.yaw = std::remainder(view.yaw, 2 * M_PI);
  const double off = std::remainder(view.yaw - reference_yaw - M_PI / 4, 2 * M_PI);
  if (std::abs(off) > M_PI / 2) {
    shape.area.yaw = std::remainder(view.yaw + M_PI, 2 * M_PI);
    std::swap(shape.walls[0], shape.walls[1]);
    std::swap(shape.closed[0], shape.closed[1]);
  }
  return shape;
}

void search(const PlaceView& view, const std::vector<Wall>& walls, const Eigen::Vector2d& position, double reference_yaw,
            const CorridorParams& params, CorridorSearch& best, double& best_length) {
  const Eigen::Vector2d p = view.to_place(position);
  for (const Face& right : view.faces[low_y]) {
    if (right.position > p.y() || p.y() - right.position > params.max_width) continue;
    for (const Face& left : view.faces[high_y]) {
      if (left.position < p.y() || left.position - right.position > params.max_width) continue;
      Candidate candidate{&right, &left, {}, {}, 0};
      const CorridorVerdict verdict = judge(view, p.x(), params, 0, &candidate);
      if (verdict != CorridorVerdict::accepted) {
        if (!best.corridor && verdict > best.verdict) best.verdict = verdict;
        continue;
      }
      // Of coplanar walls the ones with most wall stand for the corridor.
      const double length =
          right.trust * total_length(clip(right.span, candidate.along)) + left.trust * total_length(clip(left.span, candidate.along));
      if (best.corridor && length <= best_length) continue;
      best_length = length;
      best = {CorridorVerdict::accepted, shape_of(view, walls, candidate, reference_yaw)};
    }
  }
}

}  // namespace

const char* to_string(CorridorVerdict value) {
  switch (value) {
    case CorridorVerdict::accepted: return "accepted";
    case CorridorVerdict::no_walls: return "no facing walls at a corridor's width";
    case CorridorVerdict::uncovered: return "too little of a side is wall";
    case CorridorVerdict::short_: return "too short";
    case CorridorVerdict::long_: return "too long";
    case CorridorVerdict::room: return "closed at both ends and not long";
    case CorridorVerdict::cut: break;
  }
  return "another wall runs along the inside";
}

bool same_corridor(const CorridorShape& a, const CorridorShape& b, const CorridorParams& params) {
  if (std::abs(std::remainder(a.area.yaw - b.area.yaw, M_PI)) >= params.parallel) return false;
  const Eigen::Vector2d along(std::cos(a.area.yaw), std::sin(a.area.yaw));
  const Eigen::Vector2d offset = b.area.center - a.area.center;
  const double aside = std::abs(along.x() * offset.y() - along.y() * offset.x());
  const double most_aside = params.coplanar + std::abs(along.dot(offset)) * std::abs(std::sin(a.area.yaw - b.area.yaw));
  return aside <= most_aside && std::abs(a.area.size.y() - b.area.size.y()) <= 2 * params.coplanar &&
         std::abs(along.dot(offset)) < 0.5 * (a.area.size.x() + b.area.size.x());
}

CorridorSearch find_corridor(const std::vector<Wall>& walls, const Eigen::Vector2d& position, double reference_yaw, const CorridorParams& params) {
  CorridorSearch best;
  double best_length = 0;
  for (const double yaw : local_yaws(walls, position, 2 * params.max_width, params.parallel, 3)) {
    for (const double turn : {0.0, M_PI / 2}) {
      search(view_from(walls, position, yaw + turn, params.max_length, params.parallel), walls, position, reference_yaw, params, best, best_length);
    }
  }
  return best;
}

CorridorSearch judge_corridor(const std::vector<Wall>& walls, const CorridorShape& corridor, const CorridorParams& params, double slack) {
  const PlaceView view = view_from(walls, corridor.area.center, corridor.area.yaw, params.max_length, 1.5 * params.parallel);
  const auto face_of = [&](Side side, PlaneId id) {
    const auto& faces = view.faces[side];
    const auto found = std::find_if(faces.begin(), faces.end(), [&](const Face& face) { return walls[face.wall].id == id; });
    return found == faces.end() ? nullptr : &*found;
  };
  Candidate candidate{face_of(low_y, corridor.walls[0]), face_of(high_y, corridor.walls[1]), {}, {}, 0};
  if (!candidate.right || !candidate.left) return {};
  CorridorSearch result;
  result.verdict = judge(view, view.to_place(corridor.area.center).x(), params, slack, &candidate);
  if (result.verdict == CorridorVerdict::accepted) result.corridor = shape_of(view, walls, candidate, corridor.area.yaw - M_PI / 4);
  return result;
}

}  // namespace sgraph
