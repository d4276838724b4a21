#include "problem.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Index;
using Basis = Eigen::Matrix<double, 3, 2>;

std::int64_t value_of(const VariableId& id) {
  return std::visit([](const auto& typed) { return typed.value; }, id);
}

// Derivative of [n; d] by the plane's tangent coordinates.
Eigen::Matrix<double, 4, 3> by_tangent(const Basis& basis) {
  Eigen::Matrix<double, 4, 3> out = Eigen::Matrix<double, 4, 3>::Zero();
  out.topLeftCorner<3, 2>() = basis;
  out(3, 2) = 1.0;
  return out;
}

std::vector<const Factor*> factors_in(const Graph& graph, const SolveScope& scope) {
  std::vector<const Factor*> factors;
  if (!scope.free) {
    factors.reserve(graph.factors().size());
    for (const auto& [id, factor] : graph.factors()) factors.push_back(&factor);
    return factors;
  }
  std::vector<FactorId> ids;
  for (const VariableId& id : *scope.free) {
    const auto& of_variable = graph.factors_of(id);
    ids.insert(ids.end(), of_variable.begin(), of_variable.end());
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (const FactorId id : ids) factors.push_back(graph.find(id));
  return factors;
}

std::vector<VariableId> variables_of(const Graph& graph, const std::vector<const Factor*>& factors, bool all) {
  std::vector<VariableId> ids;
  if (all) {
    const auto take = [&](const auto& map) {
      for (const auto& [id, value] : map) {
        if (!graph.factors_of(id).empty()) ids.emplace_back(id);
      }
    };
    take(graph.keyframes());
    take(graph.planes());
    take(graph.rooms());
    take(graph.corridors());
    return ids;
  }
  for (const Factor* factor : factors) {
    for (const VariableId& id : blocks(factor->data)) ids.push_back(id);
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

}  // namespace

Problem::Problem(const Graph& graph, const SolveScope& scope) : Problem(graph, scope, factors_in(graph, scope), {}) {}

Problem::Problem(const Graph& graph, const SolveScope& scope, const std::vector<const Factor*>& factors,
                 const std::vector<std::pair<PlaneId, const FixedViews*>>& fixed) {
  std::vector<VariableId> ids = variables_of(graph, factors, !scope.free);
  if (!fixed.empty()) {
    for (const auto& [id, views] : fixed) ids.emplace_back(id);
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  }
  number_variables(graph, scope, ids);
  views_.reserve(factors.size());
  for (const Factor* factor : factors) add(graph, *factor);
  for (const auto& [id, views] : fixed) {
    const int variable = index_of(id);
    if (number(variable) < 0) continue;
    priors_.push_back({*views, variable});
    factors_ += views->count;
  }
}

void Problem::number_variables(const Graph& graph, const SolveScope& scope, const std::vector<VariableId>& ids) {
  variables_.reserve(ids.size());
  start_.reserve(ids.size());
  for (const VariableId& id : ids) {
    const auto* keyframe = std::get_if<KeyframeId>(&id);
    const bool gauge = keyframe != nullptr && *keyframe == graph.keyframes().begin()->first;
    const bool free = !gauge && (!scope.free || scope.free->count(id) > 0);
    int number = -1;
    if (free && keyframe != nullptr) number = keyframes_++;
    if (free && keyframe == nullptr) {
      number = static_cast<int>(landmark_widths_.size());
      landmark_widths_.push_back(tangent_size(id));
      planes_ += std::holds_alternative<PlaneId>(id) ? 1 : 0;
    }
    auto& of_kind = ids_[id.index()];
    if (of_kind.empty()) first_[id.index()] = static_cast<int>(variables_.size());
    of_kind.push_back(value_of(id));
    variables_.push_back({id, number});
    start_.push_back(block_of(graph, id));
  }
  keyframe_variables_ = static_cast<int>(ids_[0].size());
}

int Problem::index_of(const VariableId& id) const {
  const auto& of_kind = ids_[id.index()];
  return first_[id.index()] + static_cast<int>(std::lower_bound(of_kind.begin(), of_kind.end(), value_of(id)) - of_kind.begin());
}

const Problem::Variable* Problem::find(const VariableId& id) const {
  const auto& of_kind = ids_[id.index()];
  if (!std::binary_search(of_kind.begin(), of_kind.end(), value_of(id))) return nullptr;
  return &variables_[static_cast<std::size_t>(index_of(id))];
}

void Problem::add(const Graph& graph, const Factor& factor) {
  const BlockIds ids = blocks(factor.data);
  std::array<int, 2> variable{-1, -1};
  bool reached = false;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    variable[i] = index_of(ids[i]);
    reached = reached || number(variable[i]) >= 0;
  }
  if (!reached) return;
  ++factors_;
  if (const auto* fitted = std::get_if<PosePlane>(&factor.data)) {
    views_.push_back({PlaneObservation::of(*fitted), factor.loss, variable[0], variable[1]});
  } else if (const auto* points = std::get_if<PosePlanePoints>(&factor.data)) {
    views_.push_back({PlaneObservation::of(*points), factor.loss, variable[0], variable[1]});
  } else {
    terms_.push_back({make_cost(factor.data, graph), factor.loss, variable, static_cast<int>(ids.size())});
  }
}

NormalEquations Problem::pattern() {
  std::vector<NormalEquations::Pair> between;
  std::vector<NormalEquations::Pair> seen;
  std::vector<NormalEquations::Pair> coupled;
  for (const View& view : views_) {
    const int k = number(view.keyframe);
    const int p = number(view.plane);
    if (k >= 0 && p >= 0) seen.emplace_back(p, k);
  }
  for (const Term& term : terms_) {
    if (term.count < 2) continue;
    const auto [low, high] = std::minmax({number(term.variable[0]), number(term.variable[1])});
    if (low < 0) continue;
    (is_keyframe(term.variable[0]) ? between : coupled).emplace_back(low, high);
  }
  NormalEquations equations(keyframes_, landmark_widths_, std::move(between), std::move(seen), std::move(coupled));
  for (View& view : views_) {
    if (number(view.keyframe) >= 0 && number(view.plane) >= 0) view.block = equations.seen_at({number(view.plane), number(view.keyframe)});
  }
  for (Term& term : terms_) {
    if (term.count < 2) continue;
    const auto [low, high] = std::minmax({number(term.variable[0]), number(term.variable[1])});
    if (low >= 0) term.block = is_keyframe(term.variable[0]) ? equations.between_at({low, high}) : equations.coupled_at({low, high});
  }
  return equations;
}

void Problem::add_view(const View& view, const Eigen::Vector3d& e, double weight, const PlaneObservation::ByPose& by_pose,
                       const Eigen::Matrix3d& by_plane, NormalEquations& equations) const {
  const int k = number(view.keyframe);
  const int p = number(view.plane);
  if (k >= 0) {
    equations.keyframe[static_cast<std::size_t>(k)].noalias() += weight * by_pose.transpose().lazyProduct(by_pose);
    equations.gradient.segment<6>(6 * k).noalias() += weight * by_pose.transpose().lazyProduct(e);
  }
  if (p >= 0) {
    equations.landmark[static_cast<std::size_t>(p)].topLeftCorner<3, 3>().noalias() += weight * by_plane.transpose().lazyProduct(by_plane);
    equations.gradient.segment<3>(equations.keyframe_size() + equations.begin(p)).noalias() += weight * by_plane.transpose().lazyProduct(e);
  }
  if (k >= 0 && p >= 0) equations.seen[view.block].noalias() += weight * by_pose.transpose().lazyProduct(by_plane);
}

void Problem::add_term(const Term& term, const SmallVector& e, double weight, const std::array<SmallMatrix, 2>& jacobians,
                       NormalEquations& equations) const {
  const bool of_keyframes = is_keyframe(term.variable[0]);
  for (int i = 0; i < term.count; ++i) {
    const int n = number(term.variable[static_cast<std::size_t>(i)]);
    if (n < 0) continue;
    const SmallMatrix& J = jacobians[static_cast<std::size_t>(i)];
    if (of_keyframes) {
      equations.keyframe[static_cast<std::size_t>(n)].noalias() += weight * J.transpose().lazyProduct(J);
      equations.gradient.segment<6>(6 * n).noalias() += weight * J.transpose().lazyProduct(e);
    } else {
      equations.landmark[static_cast<std::size_t>(n)].topLeftCorner(J.cols(), J.cols()).noalias() += weight * J.transpose().lazyProduct(J);
      equations.gradient.segment(equations.keyframe_size() + equations.begin(n), J.cols()).noalias() += weight * J.transpose().lazyProduct(e);
    }
  }
  if (term.count < 2) return;
  int a = number(term.variable[0]);
  int b = number(term.variable[1]);
  if (a < 0 || b < 0) return;
  const std::size_t first = a < b ? 0 : 1;
  if (a > b) std::swap(a, b);
  const SmallMatrix& J_a = jacobians[first];
  const SmallMatrix& J_b = jacobians[1 - first];
  if (of_keyframes) {
    equations.between[term.block].noalias() += weight * J_a.transpose().lazyProduct(J_b);
  } else {
    equations.coupled[term.block].topLeftCorner(J_a.cols(), J_b.cols()).noalias() += weight * J_a.transpose().lazyProduct(J_b);
  }
}

double Problem::linearize(const Values& values, NormalEquations& equations) const {
  equations.set_zero();
  std::vector<Eigen::Matrix3d> rotations(static_cast<std::size_t>(keyframe_variables_));
  std::vector<Basis> bases(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i < rotations.size()) {
      const Pose pose{Eigen::Map<const Eigen::Quaterniond>(values[i].data()), Eigen::Map<const Eigen::Vector3d>(values[i].data() + 4)};
      rotations[i] = pose.matrix();
      if (variables_[i].number >= 0) equations.poses[static_cast<std::size_t>(variables_[i].number)] = pose;
    }
    if (std::holds_alternative<PlaneId>(variables_[i].id)) bases[i] = tangent_basis(Eigen::Map<const Eigen::Vector3d>(values[i].data()));
  }
  double cost = 0;
  Eigen::Vector3d e;
  PlaneObservation::ByPose by_pose;
  Eigen::Matrix3d by_plane;
  for (const View& view : views_) {
    const auto k = static_cast<std::size_t>(view.keyframe);
    const auto p = static_cast<std::size_t>(view.plane);
    view.observation.evaluate(rotations[k], Eigen::Map<const Eigen::Vector3d>(values[k].data() + 4),
                              Eigen::Map<const Eigen::Vector3d>(values[p].data()), values[p][3], bases[p], e, &by_pose, &by_plane);
    const double squared = e.squaredNorm();
    cost += 0.5 * loss_value(view.loss, squared);
    add_view(view, e, loss_weight(view.loss, squared), by_pose, by_plane, equations);
  }
  SmallVector residual;
  std::array<SmallMatrix, 2> jacobians;
  for (const Term& term : terms_) {
    std::array<const Block*, 2> x{};
    std::array<double*, 2> by{};
    residual.resize(term.cost->residual_size());
    for (std::size_t i = 0; i < static_cast<std::size_t>(term.count); ++i) {
      const auto variable = static_cast<std::size_t>(term.variable[i]);
      x[i] = &values[variable];
      jacobians[i].resize(residual.size(), tangent_size(variables_[variable].id));
      by[i] = jacobians[i].data();
    }
    term.cost->compute(x.data(), residual.data(), by.data());
    const double squared = residual.squaredNorm();
    cost += 0.5 * loss_value(term.loss, squared);
    add_term(term, residual, loss_weight(term.loss, squared), jacobians, equations);
  }
  for (const Prior& prior : priors_) {
    const auto p = static_cast<std::size_t>(prior.plane);
    const Eigen::Vector4d x = Eigen::Map<const Eigen::Vector4d>(values[p].data()) - prior.views.reference;
    const Eigen::Vector4d slope = prior.views.g + prior.views.Q * x;
    const Eigen::Matrix<double, 4, 3> J = by_tangent(bases[p]);
    const int n = number(prior.plane);
    equations.landmark[static_cast<std::size_t>(n)].topLeftCorner<3, 3>().noalias() += J.transpose() * prior.views.Q * J;
    equations.gradient.segment<3>(equations.keyframe_size() + equations.begin(n)).noalias() += J.transpose() * slope;
    cost += 0.5 * (prior.views.squared + x.dot(prior.views.g + slope));
  }
  return cost;
}

double Problem::cost(const Values& values) const {
  std::vector<Eigen::Matrix3d> rotations(static_cast<std::size_t>(keyframe_variables_));
  for (std::size_t i = 0; i < rotations.size(); ++i) rotations[i] = Eigen::Map<const Eigen::Quaterniond>(values[i].data()).toRotationMatrix();
  double cost = 0;
  Eigen::Vector3d e;
  const Basis unused = Basis::Zero();
  for (const View& view : views_) {
    const auto k = static_cast<std::size_t>(view.keyframe);
    const auto p = static_cast<std::size_t>(view.plane);
    view.observation.evaluate(rotations[k], Eigen::Map<const Eigen::Vector3d>(values[k].data() + 4),
                              Eigen::Map<const Eigen::Vector3d>(values[p].data()), values[p][3], unused, e, nullptr, nullptr);
    cost += 0.5 * loss_value(view.loss, e.squaredNorm());
  }
  SmallVector residual;
  for (const Term& term : terms_) {
    std::array<const Block*, 2> x{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(term.count); ++i) x[i] = &values[static_cast<std::size_t>(term.variable[i])];
    residual.resize(term.cost->residual_size());
    term.cost->compute(x.data(), residual.data(), nullptr);
    cost += 0.5 * loss_value(term.loss, residual.squaredNorm());
  }
  for (const Prior& prior : priors_) {
    const Eigen::Vector4d x = Eigen::Map<const Eigen::Vector4d>(values[static_cast<std::size_t>(prior.plane)].data()) - prior.views.reference;
    cost += 0.5 * (prior.views.squared + x.dot(2.0 * prior.views.g + prior.views.Q * x));
  }
  return cost;
}

Problem::Values Problem::moved(const Values& values, const Eigen::VectorXd& step) const {
  Values out = values;
  Index landmark = 6 * static_cast<Index>(keyframes_);
  for (std::size_t i = 0; i < variables_.size(); ++i) {
    const auto& [id, number] = variables_[i];
    if (number < 0) continue;
    if (is_keyframe(static_cast<int>(i))) {
      out[i] = sgraph::moved(id, values[i], step.data() + 6 * number);
    } else {
      out[i] = sgraph::moved(id, values[i], step.data() + landmark);
      landmark += tangent_size(id);
    }
  }
  return out;
}

}  // namespace sgraph
