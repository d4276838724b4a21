#include "furniture.hpp"

#include <map>

namespace sgraph::sim {

namespace {

// Centre relative to the footprint's middle on the floor, and size [m].
struct Part {
  Eigen::Vector3d center;
  Eigen::Vector3d size;
  Material material = Material::wood;
};

struct Piece {
  Eigen::Vector3d size;  // outer measures
  std::vector<Part> parts;
};

std::vector<Part> with_legs(std::vector<Part> parts, double length, double depth, double height, double leg, Material material) {
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) parts.push_back({{x * (length - leg), y * (depth - leg), height / 2}, {leg, leg, height}, material});
  }
  return parts;
}

Piece table(double length, double depth) {
  return {{length, depth, 0.74}, with_legs({{{0, 0, 0.725}, {length, depth, 0.03}}}, length, depth, 0.71, 0.06, Material::metal)};
}

Piece desk() {
  Piece piece = table(1.6, 0.8);
  piece.parts.push_back({{-0.55, 0.05, 0.33}, {0.42, 0.6, 0.6}});
  piece.parts.push_back({{0.1, 0.2, 0.99}, {0.55, 0.04, 0.34}, Material::metal});
  piece.parts.push_back({{0.1, 0.22, 0.78}, {0.08, 0.08, 0.09}, Material::metal});
  piece.size.z() = 1.16;
  return piece;
}

Piece chair() {
  return {{0.46, 0.5, 0.92},
          with_legs({{{0, 0, 0.45}, {0.46, 0.46, 0.05}}, {{0, 0.22, 0.7}, {0.42, 0.05, 0.44}}}, 0.46, 0.46, 0.43, 0.04, Material::wood)};
}

Piece shelf() {  // open boards between two sides, with a back
  Piece piece{{1.0, 0.35, 1.9},
              {{{0, 0.165, 0.95}, {1.0, 0.02, 1.9}}, {{-0.485, 0, 0.95}, {0.03, 0.35, 1.9}}, {{0.485, 0, 0.95}, {0.03, 0.35, 1.9}}}};
  for (const double z : {0.1, 0.5, 0.9, 1.3, 1.7}) piece.parts.push_back({{0, 0, z}, {0.94, 0.33, 0.03}});
  piece.parts.push_back({{-0.15, 0.03, 0.64}, {0.5, 0.24, 0.25}, Material::fabric});
  piece.parts.push_back({{0.2, 0.03, 1.05}, {0.4, 0.22, 0.27}, Material::fabric});
  return piece;
}

Piece sofa() {
  return {{2.0, 0.9, 0.82},
          {{{0, 0, 0.22}, {2.0, 0.9, 0.42}, Material::fabric},
           {{0, 0.36, 0.62}, {2.0, 0.18, 0.4}, Material::fabric},
           {{-0.92, 0, 0.52}, {0.16, 0.9, 0.2}, Material::fabric},
           {{0.92, 0, 0.52}, {0.16, 0.9, 0.2}, Material::fabric}}};
}

Piece bed() { return {{1.6, 2.0, 0.9}, {{{0, 0, 0.26}, {1.6, 2.0, 0.5}, Material::fabric}, {{0, 0.97, 0.45}, {1.6, 0.06, 0.9}}}}; }

Piece scaffold() {  // two decks on poles, as on a building site
  return {{2.0, 0.8, 2.0}, with_legs({{{0, 0, 0.45}, {2.0, 0.8, 0.05}}, {{0, 0, 1.9}, {2.0, 0.8, 0.05}}}, 2.0, 0.8, 2.0, 0.05, Material::metal)};
}

const std::map<std::string, Piece>& catalogue() {
  static const std::map<std::string, Piece> pieces{
      {"box", {{1.0, 1.0, 1.0}, {{{0, 0, 0.5}, {1.0, 1.0, 1.0}}}}},
      {"table", table(1.6, 0.8)},
      {"desk", desk()},
      {"chair", chair()},
      {"shelf", shelf()},
      {"cabinet", {{1.0, 0.45, 1.2}, {{{0, 0, 0.6}, {1.0, 0.45, 1.2}}}}},
      {"wardrobe", {{1.2, 0.6, 2.0}, {{{0, 0, 1.0}, {1.2, 0.6, 2.0}}}}},
      {"sofa", sofa()},
      {"bed", bed()},
      {"fridge", {{0.6, 0.65, 1.8}, {{{0, 0, 0.9}, {0.6, 0.65, 1.8}, Material::metal}}}},
      {"counter", {{2.4, 0.6, 0.9}, {{{0, 0, 0.43}, {2.4, 0.55, 0.86}}, {{0, 0, 0.88}, {2.4, 0.6, 0.04}}}}},
      {"plant",
       {{0.5, 0.5, 1.4}, {{{0, 0, 0.2}, {0.35, 0.35, 0.4}}, {{0, 0, 0.55}, {0.05, 0.05, 0.3}}, {{0, 0, 1.05}, {0.5, 0.5, 0.7}, Material::fabric}}}},
      {"radiator", {{1.0, 0.1, 0.6}, {{{0, 0, 0.4}, {1.0, 0.1, 0.5}, Material::metal}}}},
      {"bin", {{0.35, 0.35, 0.6}, {{{0, 0, 0.3}, {0.35, 0.35, 0.6}}}}},
      {"pallet", {{1.2, 0.8, 0.9}, {{{0, 0, 0.07}, {1.2, 0.8, 0.14}}, {{0, 0, 0.52}, {1.1, 0.75, 0.76}, Material::concrete}}}},
      {"scaffold", scaffold()}};
  return pieces;
}

}  // namespace

std::vector<Block> furniture_piece(const std::string& kind, const Eigen::Vector3d& position, double yaw, const Eigen::Vector3d& size) {
  const auto found = catalogue().find(kind);
  if (found == catalogue().end()) return {};
  const Piece& piece = found->second;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  for (int k = 0; k < 3; ++k) {
    if (size[k] > 0) scale[k] = size[k] / piece.size[k];
  }
  const Eigen::AngleAxisd turn(yaw, Eigen::Vector3d::UnitZ());
  std::vector<Block> blocks;
  for (const Part& part : piece.parts) {
    Block block;
    block.center = position + turn * part.center.cwiseProduct(scale);
    block.size = part.size.cwiseProduct(scale);
    block.yaw = yaw;
    block.material = part.material;
    block.name = kind;
    blocks.push_back(block);
  }
  return blocks;
}

std::string furniture_names() {
  std::string names;
  for (const auto& [name, piece] : catalogue()) names += (names.empty() ? "" : ", ") + name;
  return names;
}

}  // namespace sgraph::sim
