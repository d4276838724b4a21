#pragma once

#include <string>

namespace sgraph {

enum class LossKind { none, huber, cauchy, tukey, geman_mcclure };

const char* to_string(LossKind value);
/// Throws std::runtime_error for an unknown name.
LossKind loss_kind_from(const std::string& name);

/// How much a factor may pull when it contradicts the rest. Acts on the squared norm of the weighted residual; `scale` is the norm (in standard
/// deviations of the factor) beyond which it lets go.
struct RobustLoss {
  LossKind kind = LossKind::none;
  double scale = 1.0;

  static RobustLoss huber(double scale) { return {LossKind::huber, scale}; }
  static RobustLoss cauchy(double scale) { return {LossKind::cauchy, scale}; }

  friend bool operator==(const RobustLoss& a, const RobustLoss& b) { return a.kind == b.kind && a.scale == b.scale; }
};

/// What the loss makes of a squared norm: itself without a loss and near zero; it grows more slowly beyond.
double loss_value(const RobustLoss& loss, double squared_norm);

/// Its derivative: the share of its pull that the loss leaves a factor whose weighted residual has this squared norm, 1 without a loss, towards 0
/// for an outlier.
double loss_weight(const RobustLoss& loss, double squared_norm);

}  // namespace sgraph
