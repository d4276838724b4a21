#include "sgraph_slam/core/graph/robust_loss.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

namespace sgraph {
namespace {

constexpr std::array<LossKind, 5> kinds{LossKind::none, LossKind::huber, LossKind::cauchy, LossKind::tukey, LossKind::geman_mcclure};

}  // namespace

const char* to_string(LossKind value) {
  switch (value) {
    case LossKind::none: return "none";
    case LossKind::huber: return "huber";
    case LossKind::cauchy: return "cauchy";
    case LossKind::tukey: return "tukey";
    case LossKind::geman_mcclure: return "geman_mcclure";
  }
  return "?";
}

LossKind loss_kind_from(const std::string& name) {
  for (const LossKind kind : kinds) {
    if (name == to_string(kind)) return kind;
  }
  throw std::runtime_error("unknown robust loss '" + name + "' (none, huber, cauchy, tukey, geman_mcclure)");
}

double loss_value(const RobustLoss& loss, double squared_norm) {
  const double squared_scale = loss.scale * loss.scale;
  const double ratio = squared_norm / squared_scale;
  switch (loss.kind) {
    case LossKind::none: return squared_norm;
    case LossKind::huber: return ratio <= 1.0 ? squared_norm : squared_scale * (2.0 * std::sqrt(ratio) - 1.0);
    case LossKind::cauchy: return squared_scale * std::log1p(ratio);
    case LossKind::tukey: return squared_scale / 3.0 * (ratio >= 1.0 ? 1.0 : 1.0 - (1.0 - ratio) * (1.0 - ratio) * (1.0 - ratio));
    case LossKind::geman_mcclure: return squared_norm / (1.0 + ratio);
  }
  return squared_norm;
}

double loss_weight(const RobustLoss& loss, double squared_norm) {
  const double ratio = squared_norm / (loss.scale * loss.scale);
  switch (loss.kind) {
    case LossKind::none: return 1.0;
    case LossKind::huber: return ratio <= 1.0 ? 1.0 : 1.0 / std::sqrt(ratio);
    case LossKind::cauchy: return 1.0 / (1.0 + ratio);
    case LossKind::tukey: return ratio >= 1.0 ? 0.0 : (1.0 - ratio) * (1.0 - ratio);
    case LossKind::geman_mcclure: return 1.0 / ((1.0 + ratio) * (1.0 + ratio));
  }
  return 1.0;
}

}  // namespace sgraph
