#include "storey_yaml.hpp"

#include "furniture.hpp"
#include "plan.hpp"
#include "regions.hpp"

namespace sgraph::sim {

namespace {

constexpr double degree = M_PI / 180;
constexpr double whole_height = 1e3;  // an opening's top beyond any wall: cut to the wall's height

// Reads the keys of a storey or of one of its wings into the storey.
class PlanReader {
 public:
  PlanReader(Fields& fields, Storey& storey, const PlanFrame& frame, double usual_thickness)
      : plan_(fields), storey_(storey), frame_(frame), thickness_(fields.number("wall_thickness", usual_thickness, {0.02, 3})) {}

  [[nodiscard]] double thickness() const { return thickness_; }

  void walls() {
    std::vector<Wall> own;
    for (const YAML::Node& node : plan_.list_of(plan_.need("walls"))) {
      Wall like;
      like.thickness = thickness_;
      like.height = storey_.height;
      like.bottom = storey_.elevation;
      like.line = line_of(node);
      std::vector<Eigen::Vector2d> path;
      if (node.IsSequence()) {
        path = plan_.points_of(node, 2);
      } else {
        Fields fields(node, plan_.file(), "a wall");
        path = fields.points_of(fields.need("path"), 2);
        like.thickness = fields.number("thickness", thickness_, {0.02, 3});
        like.height = fields.number("height", storey_.height, {0.1, 100});
        like.glass = fields.flag("glass", false);
        like.material = fields.material("material", Material::plaster);
        fields.finish();
      }
      for (std::size_t i = 1; i < path.size(); ++i) {
        if ((path[i] - path[i - 1]).norm() < 0.05) plan_.fail(node, "a wall has two points at the same place");
      }
      for (const Wall& wall : walls_along(path, like)) own.push_back(wall);
    }
    if (own.empty()) plan_.fail(plan_.take("walls"), "`walls` is empty");
    outline(own);
    for (Wall& wall : own) {
      wall.p = frame_ * wall.p;
      wall.q = frame_ * wall.q;
      storey_.walls.push_back(wall);
    }
  }

  // Doors, windows, glass panes and plain openings differ by their defaults.
  void openings(const char* key, const Opening& usual, double usual_width) {
    for (const YAML::Node& node : plan_.list_of(plan_.take(key))) {
      Opening opening = usual;
      double width = usual_width;
      std::vector<Eigen::Vector2d> places;
      if (node.IsSequence()) {
        places = places_of(node);
      } else {
        Fields fields(node, plan_.file(), std::string("an entry of `") + key + "`");
        places = places_of(fields.need("at"));
        width = fields.number("width", usual_width, {0.05, 200});
        opening.bottom = fields.number("bottom", usual.bottom, {0, 100});
        opening.top = fields.number("top", usual.top, {0.05, 1000});
        opening.joins = !usual.pane && fields.flag("joins", false);
        fields.finish();
      }
      for (const Eigen::Vector2d& at : places) {
        const std::string error = cut_opening(storey_.walls, at, width, opening);
        if (!error.empty()) plan_.fail(node, std::string("`") + key + "`: " + error);
      }
    }
  }

  void columns() {
    for (const YAML::Node& node : plan_.list_of(plan_.take("columns"))) {
      Fields fields(node, plan_.file(), "a column");
      Block column;
      column.name = "column";
      column.line = line_of(node);
      column.material = fields.material("material", Material::concrete);
      column.yaw = frame_.yaw + degree * fields.number("yaw_deg", 0, {-360, 360});
      const double height = fields.number("height", storey_.height, {0.1, 100});
      if (fields.has("diameter")) {
        column.round = true;
        const double diameter = fields.number("diameter", 0.4, {0.05, 5});
        column.size = {diameter, diameter, height};
      } else {
        const YAML::Node size = fields.need("size");
        const std::vector<double> sides = size.IsScalar() ? std::vector<double>(2, fields.number("size", 0.4, {0.05, 5})) : fields.numbers(size, 2);
        if (sides[0] < 0.05 || sides[1] < 0.05) fields.fail(size, "a column's `size` must be at least 0.05");
        column.size = {sides[0], sides[1], height};
      }
      for (const Eigen::Vector2d& at : places_of(fields.need("at"))) {
        column.center = {at.x(), at.y(), storey_.elevation + 0.5 * height};
        storey_.columns.push_back(column);
      }
      fields.finish();
    }
  }

  void furniture() {
    for (const YAML::Node& node : plan_.list_of(plan_.take("furniture"))) {
      Fields fields(node, plan_.file(), "a piece of furniture");
      fields.need("kind");
      const std::string kind = fields.text("kind", "");
      const double yaw = frame_.yaw + degree * fields.number("yaw_deg", 0, {-360, 360});
      const double z = fields.number("z", 0, {0, 100});
      const Eigen::Vector3d size = furniture_size(fields);
      for (const Eigen::Vector2d& at : places_of(fields.need("at"))) {
        std::vector<Block> blocks = furniture_piece(kind, {at.x(), at.y(), storey_.elevation + z}, yaw, size);
        if (blocks.empty()) fields.fail(node, "no furniture is called `" + kind + "`; there are " + furniture_names());
        const int piece = storey_.furniture.empty() ? 1 : storey_.furniture.back().piece + 1;
        for (Block& block : blocks) {
          block.piece = piece;
          block.line = line_of(node);
          storey_.furniture.push_back(block);
        }
      }
      fields.finish();
    }
  }

  void places(const char* key, std::vector<Place>& places) {
    const YAML::Node node = plan_.take(key);
    if (node.IsNull()) return;
    if (!node.IsMap()) plan_.fail(node, std::string("`") + key + "` must be a map from names to points");
    for (const auto& entry : node) {
      const std::string name = entry.first.Scalar();
      YAML::Node at = entry.second;
      double yaw = frame_.yaw;
      if (entry.second.IsMap()) {
        Fields fields(entry.second, plan_.file(), name);
        at.reset(fields.need("at"));
        yaw += degree * fields.number("yaw_deg", 0, {-360, 360});
        fields.finish();
      }
      std::string error;
      std::optional<Place> place = place_between_walls(storey_, frame_ * plan_.point_of(at), yaw, error);
      if (!place) plan_.fail(entry.first, name + ": " + error);
      place->name = name;
      places.push_back(*place);
      storey_.seeds.push_back({name, std::string(key) == "corridors" ? "corridor" : "room", place->center, false, line_of(entry.first)});
    }
  }

  void seeds() {
    const YAML::Node node = plan_.take("places");
    if (node.IsNull()) return;
    if (!node.IsMap()) plan_.fail(node, "`places` must be a map from names to points");
    for (const auto& entry : node) {
      PlaceSeed seed{entry.first.Scalar(), "room", {}, true, line_of(entry.first)};
      YAML::Node at = entry.second;
      if (entry.second.IsMap()) {
        Fields fields(entry.second, plan_.file(), seed.name);
        at.reset(fields.need("at"));
        seed.kind = fields.text("kind", "room");
        if (seed.kind != "room" && seed.kind != "corridor" && seed.kind != "hall" && seed.kind != "open_plan")
          fields.fail(entry.second, "`kind` must be room, corridor, hall or open_plan");
        fields.finish();
      }
      seed.at = frame_ * plan_.point_of(at);
      storey_.seeds.push_back(seed);
    }
  }

 private:
  void outline(const std::vector<Wall>& own) {
    const YAML::Node given = plan_.take("outline");
    std::vector<Eigen::Vector2d> outline = given.IsNull() ? bounding_outline(own) : plan_.points_of(given, 3);
    for (Eigen::Vector2d& p : outline) p = frame_ * p;
    storey_.outlines.push_back(outline);
  }

  // One point, or a list of points: the same thing at several places.
  [[nodiscard]] std::vector<Eigen::Vector2d> places_of(const YAML::Node& at) const {
    std::vector<Eigen::Vector2d> places;
    if (at.IsSequence() && at.size() > 0 && at[0].IsSequence()) {
      places = plan_.points_of(at, 1);
    } else {
      places = {plan_.point_of(at)};
    }
    for (Eigen::Vector2d& p : places) p = frame_ * p;
    return places;
  }

  static Eigen::Vector3d furniture_size(Fields& fields) {
    Eigen::Vector3d size = Eigen::Vector3d::Zero();
    const YAML::Node given = fields.take("size");
    if (given.IsNull()) return size;
    const std::vector<double> values = fields.numbers(given, 3);
    for (int k = 0; k < 3; ++k) {
      size[k] = values[static_cast<std::size_t>(k)];
      if (size[k] <= 0 || size[k] > 100) fields.fail(given, "each of `size` must be between 0 and 100");
    }
    return size;
  }

  Fields& plan_;
  Storey& storey_;
  PlanFrame frame_;
  double thickness_;
};

}  // namespace

Storey read_storey(Fields& fields, const std::string& name, PlanFrames& frames) {
  Storey storey;
  storey.name = fields.text("storey", name);
  for (const auto& [key, voids] : {std::pair{"floor_voids", &storey.floor_voids}, {"ceiling_voids", &storey.ceiling_voids}}) {
    for (const YAML::Node& node : fields.list_of(fields.take(key))) {
      const std::vector<Eigen::Vector2d> corners = fields.points_of(node, 2);
      if (corners.size() != 2 || (corners[1] - corners[0]).minCoeff() < 0.1)
        fields.fail(node, std::string("`") + key + "` needs the low and the high corner of each rectangle");
      voids->push_back(corners);
    }
  }
  storey.elevation = fields.number("elevation", 0, {-100, 1000});
  storey.height = fields.number("height", 2.8, {1, 50});
  storey.floor = fields.flag("floor", true);
  storey.ceiling = fields.flag("ceiling", true);
  frames[""] = {};
  std::vector<Fields> wings;
  std::vector<PlanFrame> wing_frames;
  for (const YAML::Node& node : fields.list_of(fields.take("wings"))) {
    wings.emplace_back(node, fields.file(), "a wing");
    wings.back().need("name");
    const std::string wing = wings.back().text("name", "");
    if (frames.count(wing) != 0) fields.fail(node, "two wings are called `" + wing + "`");
    wing_frames.push_back({wings.back().point("at"), degree * wings.back().number("yaw_deg", 0, {-360, 360})});
    frames[wing] = wing_frames.back();
  }
  std::vector<PlanReader> readers{PlanReader(fields, storey, {}, 0.15)};
  for (std::size_t i = 0; i < wings.size(); ++i) readers.emplace_back(wings[i], storey, wing_frames[i], readers.front().thickness());

  // All walls first: openings and places look for them.
  for (PlanReader& reader : readers) reader.walls();
  for (PlanReader& reader : readers) {
    reader.openings("doors", {0, 0, 0, 2.1, false, false, false}, 0.95);
    reader.openings("openings", {0, 0, 0, whole_height, false, false, false}, 1.5);
    reader.openings("windows", {0, 0, 0.9, 2.2, true, false, false}, 1.4);
    reader.openings("glass", {0, 0, 0, whole_height, true, false, false}, 2.0);
    reader.columns();
    reader.furniture();
    reader.places("rooms", storey.rooms);
    reader.places("corridors", storey.corridors);
    reader.seeds();
  }
  for (const Fields& wing : wings) wing.finish();
  storey.regions = regions_of(storey, fields.file());
  return storey;
}

}  // namespace sgraph::sim
