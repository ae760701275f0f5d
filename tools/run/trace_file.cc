#include "tools/run/trace_file.h"

#include <map>
#include <nlohmann/json.hpp>

#include "core/trace/trace.h"

namespace pirvs::tools {

std::string trace_json() {
  struct Lanes {
    std::map<std::string, int> lane;
    nlohmann::json events = nlohmann::json::array();
  } lanes;
  trace_events(&lanes, [](void* context, const TraceEvent& event) {
    Lanes& out = *static_cast<Lanes*>(context);
    const int next = static_cast<int>(out.lane.size());
    const int lane = out.lane.emplace(event.name, next).first->second;
    out.events.push_back({{"name", event.name},
                          {"ph", "X"},
                          {"pid", 0},
                          {"tid", lane},
                          {"ts", static_cast<double>(event.begin) * 1e-3},
                          {"dur", static_cast<double>(event.end - event.begin) * 1e-3}});
  });
  for (const auto& [name, lane] : lanes.lane) {
    lanes.events.push_back({{"name", "thread_name"},
                            {"ph", "M"},
                            {"pid", 0},
                            {"tid", lane},
                            {"args", {{"name", name}}}});
  }
  return nlohmann::json{{"traceEvents", lanes.events}}.dump();
}

}  // namespace pirvs::tools
