#include "sgraph_slam/core/pipeline/variants.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace sgraph {
namespace {

constexpr const char* name_characters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";

bool flag_from(const std::string& key, const std::string& word) {
  if (word != "true" && word != "false") throw ParamError({key + " is true or false, not '" + word + "'"});
  return word == "true";
}

// Takes what is no parameter out of the values.
void apply_own_keys(ParamValues& values, Variant& variant) {
  if (const auto until = values.extract("until")) {
    const auto stage = stage_from(until.mapped());
    if (!stage) throw ParamError({"until is a stage (prefilter, odometry, segmentation, mapping), not '" + until.mapped() + "'"});
    variant.until = *stage;
  }
  if (const auto imu = values.extract("imu")) variant.imu = flag_from("imu", imu.mapped());
  const auto source = values.find("odometry.source");
  if (source != values.end() && source->second == "topic") variant.encoders = true;
  if (const auto encoders = values.extract("encoders")) variant.encoders = flag_from("encoders", encoders.mapped());
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

// What decides about the motion; variants that agree in it share a front end.
std::string front_key(const Variant& variant) {
  Params params = variant.params;
  const std::string text = to_yaml([&params](ParamVisitor& v) {
    v.group("prefilter", params.prefilter, "");
    v.group("odometry", params.odometry, "");
    v.group("robot", params.odometry.robot, "");
  });
  return text + (variant.encoders ? "encoders " : "") + (variant.imu ? "imu " : "") + (variant.until == Stage::prefilter ? "prefilter" : "");
}

std::string segmentation_key(const Variant& variant) {
  if (variant.until < Stage::segmentation) return "";
  SegmentationParams params = variant.params.segmentation;
  return to_yaml([&params](ParamVisitor& v) { v.group("segmentation", params, ""); });
}

// The group of that key; null when there is none.
template <class Groups>
typename Groups::value_type* with_key(Groups& groups, const std::string& key) {
  const auto found = std::find_if(groups.begin(), groups.end(), [&key](const auto& group) { return group.key == key; });
  return found != groups.end() ? &*found : nullptr;
}

}  // namespace

Variant parse_variant(const std::string& text, const ParamValues& common, const Variant& base) {
  Variant variant = base;
  const std::size_t colon = text.find(':');
  variant.name = text.substr(0, colon);
  if (variant.name.empty() || variant.name.find_first_not_of(name_characters) != std::string::npos) {
    throw ParamError({"variant '" + text + "': its name must be of letters, digits, _ and - (NAME:key=value,key=value)"});
  }
  try {
    ParamValues values = common;
    if (colon != std::string::npos) {
      for (const std::string& assignment : split(text.substr(colon + 1), ',')) set_value(values, assignment);
    }
    apply_own_keys(values, variant);
    apply_values(values, [&variant](ParamVisitor& v) { variant.params.describe(v); });
  } catch (const ParamError& error) {
    std::vector<std::string> lines;
    for (const std::string& line : error.errors()) lines.push_back("variant " + variant.name + ": " + line);
    throw ParamError(lines);
  }
  return variant;
}

VariantSet::VariantSet(std::vector<Variant> variants, const Pose& T_base_lidar, const SessionStart& start) : variants_(std::move(variants)) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < variants_.size(); ++i) {
    const Variant& variant = variants_[i];
    if (!names.insert(variant.name).second) throw std::runtime_error("two variants are named " + variant.name);
    runs_.emplace_back(variant.params.mapping, T_base_lidar, variant.until, start);
    const std::string key = front_key(variant);
    Front* front = with_key(fronts_, key);
    if (front == nullptr) {
      fronts_.push_back({key, variant.encoders, variant.imu, FrontEnd(variant.params, T_base_lidar, variant.until), {}});
      front = &fronts_.back();
    }
    const std::string planes = segmentation_key(variant);
    Segmentation* segmentation = with_key(front->segmentations, planes);
    if (segmentation == nullptr) {
      front->segmentations.push_back({planes, std::nullopt, {}});
      segmentation = &front->segmentations.back();
      if (!planes.empty()) segmentation->segmenter.emplace(variant.params.segmentation);
    }
    segmentation->runs.push_back(i);
  }
}

std::shared_ptr<const RingCalibration> VariantSet::calibration(std::size_t variant) const {
  for (const Front& front : fronts_) {
    for (const Segmentation& segmentation : front.segmentations) {
      if (std::find(segmentation.runs.begin(), segmentation.runs.end(), variant) != segmentation.runs.end()) return front.front_end.calibration();
    }
  }
  return std::make_shared<const RingCalibration>();
}

void VariantSet::add(const OdometrySample& sample) {
  for (Front& front : fronts_) {
    if (front.encoders) front.front_end.add(sample);
  }
}

void VariantSet::add(const ImuSample& sample) {
  for (Front& front : fronts_) {
    if (front.imu) front.front_end.add(sample);
  }
}

template <class Take>
void VariantSet::hand_on(const Front& front, const MeasuredScan& scan, Take take) {
  for (const Segmentation& segmentation : front.segmentations) {
    MeasuredScan measured = scan;
    if (segmentation.segmenter) segment(*segmentation.segmenter, measured);
    for (const std::size_t i : segmentation.runs) take(runs_[i], measured);
  }
}

void VariantSet::process(const Cloud& raw) {
  for (Front& front : fronts_) {
    hand_on(front, front.front_end.process(raw), [](Run& run, const MeasuredScan& scan) { run.take(scan); });
  }
}

void VariantSet::finish() {
  for (Front& front : fronts_) {
    hand_on(front, front.front_end.finish(), [](Run& run, const MeasuredScan& rest) { run.finish(rest); });
  }
}

}  // namespace sgraph
