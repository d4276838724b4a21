#include "stage_nodelet.hpp"

namespace sgraph {

void StageNodelet::onInit() {
  try {
    settings_ = load_settings(getNodeHandle());
    health_ = std::make_unique<Health>(getNodeHandle(), getPrivateNodeHandle(), getName());
    start();
  } catch (const ParamError& error) {
    for (const std::string& line : error.errors()) NODELET_FATAL_STREAM("parameter error: " << line);
    throw;
  } catch (const std::exception& error) {
    NODELET_FATAL_STREAM("can't start: " << error.what());
    throw;
  }
}

}  // namespace sgraph
