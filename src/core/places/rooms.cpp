#include "sgraph_slam/core/places/rooms.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "sgraph_slam/core/planes/dominant_frame.hpp"

namespace sgraph {
namespace {

constexpr double corner_margin = 0.3;  // what is this near to a side does not cut the inside [m]
constexpr double size_weight = 0.4;    // a tenth more area is worth four hundredths of the outline
constexpr double wall_weight = 0.3;
constexpr double side_height = 0.5;  // what is lower than this share of the highest side is furniture, not a wall
constexpr std::size_t most_candidates = 10;

struct Candidate {
  std::array<const Face*, 4> sides;
  Rectangle area;
};

double length_over_width(const Rectangle& r) { return std::max(r.x.length(), r.y.length()) / std::min(r.x.length(), r.y.length()); }

RoomVerdict judge_widths(const Rectangle& area, const RoomParams& params) {
  const double narrow = std::min(area.x.length(), area.y.length());
  if (narrow < params.min_width)
    return narrow >= 0.4 * params.min_width && length_over_width(area) >= params.corridor_aspect ? RoomVerdict::corridor : RoomVerdict::narrow;
  if (narrow <= params.corridor_width && length_over_width(area) >= params.corridor_aspect) return RoomVerdict::corridor;
  if (std::max(area.x.length(), area.y.length()) > params.max_width) return RoomVerdict::wide;
  return RoomVerdict::accepted;
}

// Length of a segment within a rectangle.
double length_inside(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Rectangle& area) {
  double enter = 0;
  double leave = 1;
  const Eigen::Vector2d step = to - from;
  for (const auto& [begin, change, range] : {std::tuple{from.x(), step.x(), area.x}, std::tuple{from.y(), step.y(), area.y}}) {
    if (std::abs(change) < 1e-12) {
      if (begin < range.low || begin > range.high) return 0;
      continue;
    }
    const double a = (range.low - begin) / change;
    const double b = (range.high - begin) / change;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return leave > enter ? (leave - enter) * step.norm() : 0;
}

// Whether walls across one axis (both facings) run through the inside: over a large share of it, the two faces and the two sides of a door together.
// What is lower than `least_height` stands in the room.
bool cut_across(const std::vector<Face>& low_faces, const std::vector<Face>& high_faces, Interval across, Interval along, double least_height,
                const RoomParams& params) {
  struct Inside {
    double position;
    const Face* face;
  };
  std::vector<Inside> inside;
  for (const bool low : {true, false}) {
    for (const Face& face : low ? low_faces : high_faces) {
      if (face.height < least_height) continue;
      if (face.position < across.low + corner_margin || face.position > across.high - corner_margin) continue;
      const double before_wall = low ? face.position - across.low : across.high - face.position;
      if (before_wall <= params.furniture_depth) continue;
      inside.push_back({face.position, &face});
    }
  }
  for (const Inside& one : inside) {
    Intervals spans;
    for (const Inside& other : inside) {
      if (std::abs(other.position - one.position) <= corner_margin) spans.insert(spans.end(), other.face->span.begin(), other.face->span.end());
    }
    if (total_length(clip(unite(std::move(spans)), along)) >= params.cut_share * along.length()) return true;
  }
  return false;
}

bool is_cut(const PlaceView& view, const Rectangle& area, double least_height, const RoomParams& params) {
  if (cut_across(view.faces[low_x], view.faces[high_x], area.x, area.y, least_height, params)) return true;
  if (cut_across(view.faces[low_y], view.faces[high_y], area.y, area.x, least_height, params)) return true;
  const double limit = params.cut_share * std::min(area.x.length(), area.y.length());
  const Rectangle inner{{area.x.low + corner_margin, area.x.high - corner_margin}, {area.y.low + corner_margin, area.y.high - corner_margin}};
  return std::any_of(view.oblique.begin(), view.oblique.end(),
                     [&](const ObliqueWall& wall) { return length_inside(wall.from, wall.to, inner) >= limit; });
}

struct Coverage {
  double all = 0;
  double wall = 0;
};

// Of the lowest and of the highest side [m].
Interval heights(const Candidate& candidate) {
  const auto lower = [](const Face* a, const Face* b) { return a->height < b->height; };
  const auto [lowest, highest] = std::minmax_element(candidate.sides.begin(), candidate.sides.end(), lower);
  return {(*lowest)->height, (*highest)->height};
}

// All tests on one candidate; the shares of its outline that have been seen go to `coverage`.
RoomVerdict judge(const PlaceView& view, const Candidate& candidate, const RoomParams& params, double slack, Coverage* coverage) {
  const RoomVerdict widths = judge_widths(candidate.area, params);
  if (widths != RoomVerdict::accepted) return widths;
  const double ease = 1 - slack;
  const Interval height = heights(candidate);
  if (height.low < ease * side_height * height.high) return RoomVerdict::uncovered;
  for (const Side side : {low_x, high_x, low_y, high_y}) {
    const bool across_x = side == low_x || side == high_x;
    const bool low = side == low_x || side == low_y;
    const Interval along = across_x ? candidate.area.y : candidate.area.x;
    const double at = candidate.sides[side]->position;
    const double wall = side_coverage(view.faces[side], low, at, along, params.coplanar, 0);
    const double all = side_coverage(view.faces[side], low, at, along, params.coplanar, params.furniture_depth);
    if (wall < ease * params.min_wall_coverage || all < ease * params.min_side_coverage) return RoomVerdict::uncovered;
    const double share = along.length() / (2 * (candidate.area.x.length() + candidate.area.y.length()));
    coverage->all += all * share;
    coverage->wall += wall * share;
  }
  if (coverage->all < ease * params.min_coverage) return RoomVerdict::uncovered;
  return is_cut(view, candidate.area, side_height * height.high, params) ? RoomVerdict::cut : RoomVerdict::accepted;
}

RoomShape shape_of(const PlaceView& view, const std::vector<Wall>& walls, const Candidate& candidate, const Coverage& coverage,
                   double reference_yaw) {
  const int turns = static_cast<int>(std::lround((reference_yaw - view.yaw) / (M_PI / 2)));
  RoomShape room;
  room.coverage = coverage.all;
  room.wall_coverage = coverage.wall;
  room.area.center = view.to_map({candidate.area.x.center(), candidate.area.y.center()});
  room.area.size = {candidate.area.x.length(), candidate.area.y.length()};
  room.area.yaw = std::remainder(view.yaw + turns * M_PI / 2, 2 * M_PI);
  if (turns % 2 != 0) std::swap(room.area.size.x(), room.area.size.y());
  // Sides in the order of a left turn; a quarter turn of the axes moves each one place on.
  constexpr std::array<Side, 4> around{high_x, high_y, low_x, low_y};
  for (int i = 0; i < 4; ++i) {
    const Side from = around[static_cast<std::size_t>(((i + turns) % 4 + 4) % 4)];
    room.walls[around[static_cast<std::size_t>(i)]] = walls[candidate.sides[from]->wall].id;
  }
  return room;
}

double weight(const Face& face) { return total_length(face.span) * face.trust; }

// The nearest faces of a side beyond a position; of coplanar ones only that with most wall, as far as it can be trusted.
std::vector<const Face*> candidates_of(const std::vector<Face>& faces, bool low, double position, const RoomParams& params) {
  std::vector<const Face*> found;
  for (const Face& face : faces) {
    const double away = low ? position - face.position : face.position - position;
    if (away > 0 && away < params.max_width) found.push_back(&face);
  }
  std::sort(found.begin(), found.end(),
            [](const Face* a, const Face* b) { return weight(*a) > weight(*b) || (weight(*a) == weight(*b) && a->wall < b->wall); });
  std::vector<const Face*> distinct;
  for (const Face* face : found) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Face* d) {
      return std::abs(d->position - face->position) < 0.5 * params.coplanar && overlap(hull(d->span), hull(face->span)) > 0;
    });
    if (!known) distinct.push_back(face);
  }
  std::sort(distinct.begin(), distinct.end(),
            [&](const Face* a, const Face* b) { return std::abs(a->position - position) < std::abs(b->position - position); });
  if (distinct.size() > most_candidates) distinct.resize(most_candidates);
  return distinct;
}

void search(const PlaceView& view, const std::vector<Wall>& walls, const Eigen::Vector2d& position, double reference_yaw, const RoomParams& params,
            RoomSearch& best) {
  const Eigen::Vector2d p = view.to_place(position);
  std::array<std::vector<const Face*>, 4> options;
  for (const Side side : {low_x, high_x, low_y, high_y}) {
    options[side] = candidates_of(view.faces[side], side == low_x || side == low_y, side < low_y ? p.x() : p.y(), params);
  }
  for (const Face* x1 : options[low_x]) {
    for (const Face* x2 : options[high_x]) {
      const Interval x{x1->position, x2->position};
      if (x.length() > params.max_width || x.length() < 0.4 * params.min_width) continue;
      for (const Face* y1 : options[low_y]) {
        if (overlap(hull(y1->span), x) <= 0) continue;
        for (const Face* y2 : options[high_y]) {
          if (overlap(hull(y2->span), x) <= 0) continue;
          const Candidate candidate{{x1, x2, y1, y2}, {x, {y1->position, y2->position}}};
          Coverage coverage;
          const RoomVerdict verdict = judge(view, candidate, params, 0, &coverage);
          if (verdict != RoomVerdict::accepted) {
            if (!best.room && verdict > best.verdict) best.verdict = verdict;
          } else {
            const RoomShape shape = shape_of(view, walls, candidate, coverage, reference_yaw);
            if (!best.room || room_score(shape) > room_score(*best.room)) best = {RoomVerdict::accepted, shape};
          }
        }
      }
    }
  }
}

const Face* face_of_plane(const std::vector<Face>& faces, const std::vector<Wall>& walls, PlaneId id) {
  const auto found = std::find_if(faces.begin(), faces.end(), [&](const Face& face) { return walls[face.wall].id == id; });
  return found == faces.end() ? nullptr : &*found;
}

}  // namespace

const char* to_string(RoomVerdict value) {
  switch (value) {
    case RoomVerdict::accepted: return "accepted";
    case RoomVerdict::no_walls: return "not walls on all four sides";
    case RoomVerdict::narrow: return "too narrow";
    case RoomVerdict::wide: return "too wide";
    case RoomVerdict::corridor: return "long and narrow as a corridor";
    case RoomVerdict::uncovered: return "too little of a side is wall";
    case RoomVerdict::cut: break;
  }
  return "another wall runs through the inside";
}

double room_score(const RoomShape& room) {
  return room.coverage + wall_weight * room.wall_coverage + size_weight * std::log(std::max(1e-6, room.area.area()));
}

RoomSearch find_room(const std::vector<Wall>& walls, const Eigen::Vector2d& position, double reference_yaw, const RoomParams& params) {
  RoomSearch best;
  const double reach = 1.5 * params.max_width;
  for (const double yaw : local_yaws(walls, position, params.max_width, params.parallel, 3)) {
    search(view_from(walls, position, yaw, reach, params.parallel), walls, position, reference_yaw, params, best);
  }
  return best;
}

RoomSearch judge_room(const std::vector<Wall>& walls, const RoomShape& room, const RoomParams& params, double slack) {
  const PlaceView view = view_from(walls, room.area.center, room.area.yaw, 1.5 * params.max_width, 1.5 * params.parallel);
  Candidate candidate{};
  for (const Side side : {low_x, high_x, low_y, high_y}) {
    candidate.sides[side] = face_of_plane(view.faces[side], walls, room.walls[side]);
    if (!candidate.sides[side]) return {};
  }
  candidate.area = {{candidate.sides[low_x]->position, candidate.sides[high_x]->position},
                    {candidate.sides[low_y]->position, candidate.sides[high_y]->position}};
  RoomParams eased = params;
  eased.min_width *= 1 - 0.2 * slack;
  eased.max_width *= 1 + 0.2 * slack;
  eased.corridor_aspect *= 1 + 0.5 * slack;
  eased.cut_share = std::min(1.0, params.cut_share * (1 + 0.3 * slack));
  Coverage coverage;
  RoomSearch result;
  result.verdict = judge(view, candidate, eased, slack, &coverage);
  if (result.verdict == RoomVerdict::accepted) result.room = shape_of(view, walls, candidate, coverage, room.area.yaw);
  return result;
}

}  // namespace sgraph
