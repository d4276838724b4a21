#include "sgraph_slam/core/sensor/stamp_filter.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

constexpr std::size_t most_waiting = 3;   // scans with wrong stamps that come together
constexpr double reception_jitter = 2.0;  // [s] that network and computer may hold a scan back

}  // namespace

bool StampFilter::paused_between(const Seen& before, const Seen& after) {
  if (!before.received || !after.received) return false;
  return std::abs((*after.received - *before.received) - (after.scan->stamp - before.scan->stamp)) < reception_jitter;
}

CloudPtr StampFilter::moved(const CloudPtr& scan) const {
  if (shift_ == 0) return scan;
  auto copy = std::make_shared<Cloud>(*scan);
  copy->stamp = scan->stamp.after(shift_);
  return copy;
}

std::vector<CloudPtr> StampFilter::push(const CloudPtr& scan, const std::optional<Stamp>& received) {
  Seen seen{scan, received};
  const auto pass = [&](const Seen& one) {
    if (last_) {
      const double step = one.scan->stamp - last_->scan->stamp;
      if (step > 0 && step < far) spacing_ = step;
    }
    last_ = {one.scan, one.received};
    return moved(one.scan);
  };
  if (!last_) return {pass(seen)};
  const double step = scan->stamp - last_->scan->stamp;
  if (std::abs(step) <= far || paused_between(*last_, seen) || (step < 0 && backward_ == Backward::passes)) {
    dropped_ += static_cast<int>(waiting_.size());
    waiting_.clear();
    return {pass(seen)};
  }
  if (!waiting_.empty()) {
    const double apart = scan->stamp - waiting_.back().scan->stamp;
    if (apart > 0 && apart <= far) {
      const double jump = waiting_.front().scan->stamp - last_->scan->stamp;
      if (jump < 0 || shift_ > 0) shift_ = std::max(0.0, shift_ + spacing_ - jump);
      std::vector<CloudPtr> passing;
      for (const Seen& one : waiting_) passing.push_back(pass(one));
      waiting_.clear();
      passing.push_back(pass(seen));
      return passing;
    }
  }
  waiting_.push_back(std::move(seen));
  if (waiting_.size() > most_waiting) {
    waiting_.erase(waiting_.begin());
    ++dropped_;
  }
  return {};
}

void StampFilter::finish() {
  dropped_ += static_cast<int>(waiting_.size());
  waiting_.clear();
}

}  // namespace sgraph
