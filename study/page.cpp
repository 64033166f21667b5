#include <algorithm>
#include <cmath>
#include <modsearch/problem/markup.hpp>
#include <modsearch/study/html_internal.hpp>
#include <modsearch/study/page.hpp>
#include <modsearch/study/page_assets_internal.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string_view>

namespace modsearch {
namespace {

using Json = nlohmann::json;

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("write_page: " + what); }

// A micrometre is far below a pixel, and short numbers keep the page of a long path small.
double rounded(double value) { return std::round(value * 1e6) / 1e6 + 0.0; }

Json rounded_numbers(std::span<const double> values, const std::string& what) {
  Json out = Json::array();
  for (const double value : values) {
    if (!std::isfinite(value)) refuse(what + " is not finite");
    out.push_back(rounded(value));
  }
  return out;
}

// The twelve numbers that matter of a pose; its last row is always 0 0 0 1.
Json pose_json(const PagePose& pose, const std::string& what) {
  return rounded_numbers(std::span(pose).first(12), "the pose of " + what);
}

struct KindFacts {
  std::string_view name;
  std::size_t sizes;  // how many numbers describe it
};

KindFacts facts_of(PageShapeKind kind) {
  switch (kind) {
    case PageShapeKind::kSphere:
      return {"sphere", 1};
    case PageShapeKind::kBox:
      return {"box", 3};
    case PageShapeKind::kCylinder:
      return {"cylinder", 2};
    case PageShapeKind::kCapsule:
      return {"capsule", 2};
    case PageShapeKind::kMesh:
      return {"mesh", 0};
  }
  refuse("unknown kind of shape");
}

std::string_view name_of(PageJointKind kind) {
  switch (kind) {
    case PageJointKind::kRevolute:
      return "revolute";
    case PageJointKind::kPrismatic:
      return "prismatic";
    case PageJointKind::kFixed:
      return "fixed";
  }
  refuse("unknown kind of joint");
}

Json shape_json(const PageShape& shape, const std::string& owner) {
  const KindFacts facts = facts_of(shape.kind);
  const std::string what = "the " + std::string(facts.name) + " of " + owner;
  if (shape.size.size() != facts.sizes) {
    refuse(what + " has " + std::to_string(shape.size.size()) + " sizes instead of " + std::to_string(facts.sizes));
  }
  Json out{{"kind", facts.name},
           {"name", shape.name},
           {"size", rounded_numbers(shape.size, "a size of " + what)},
           {"X", pose_json(shape.X_BG, what)}};
  if (shape.kind != PageShapeKind::kMesh) return out;

  Json& vertices = out["vertices"] = Json::array();
  for (const PagePoint& vertex : shape.vertices) {
    for (Json& coordinate : rounded_numbers(vertex, "a vertex of " + what)) vertices.push_back(std::move(coordinate));
  }
  Json& triangles = out["triangles"] = Json::array();
  for (const std::array<int, 3>& triangle : shape.triangles) {
    for (const int index : triangle) {
      if (index < 0 || static_cast<std::size_t>(index) >= shape.vertices.size()) {
        refuse(what + " names vertex " + std::to_string(index) + " of " + std::to_string(shape.vertices.size()));
      }
      triangles.push_back(index);
    }
  }
  return out;
}

Json body_json(const PageBody& body, std::size_t samples) {
  const std::string what = "body '" + body.name + "'";
  if (body.keyframes.size() != 1 && body.keyframes.size() != samples) {
    refuse(what + " has " + std::to_string(body.keyframes.size()) + " keyframes; the path has " +
           std::to_string(samples) + " samples");
  }
  Json out{{"name", body.name}, {"module", body.module}};
  Json& shapes = out["shapes"] = Json::array();
  for (const PageShape& shape : body.shapes) shapes.push_back(shape_json(shape, what));
  Json& joints = out["joints"] = Json::array();
  for (const PageJoint& joint : body.joints) {
    joints.push_back(
        {{"name", joint.name}, {"kind", name_of(joint.kind)}, {"X", pose_json(joint.X_BJ, "a joint of " + what)}});
  }
  Json& keyframes = out["keyframes"] = Json::array();
  for (const PagePose& pose : body.keyframes) keyframes.push_back(pose_json(pose, what));
  return out;
}

// How many samples the path has: the largest count that anything along it gives.
std::size_t samples_of(const Page& page) {
  std::size_t samples = std::max({std::size_t{1}, page.tip.size(), page.times.size()});
  for (const std::vector<PageBody>* bodies : {&page.bodies, &page.obstacles}) {
    for (const PageBody& body : *bodies) samples = std::max(samples, body.keyframes.size());
  }
  return samples;
}

void check_along_path(std::string_view what, std::size_t count, std::size_t samples) {
  if (count != 0 && count != samples) {
    refuse(std::string(what) + " has " + std::to_string(count) + " entries; the path has " + std::to_string(samples) +
           " samples");
  }
}

Json scene_json(const Page& page) {
  const std::size_t samples = samples_of(page);
  check_along_path("tip", page.tip.size(), samples);
  check_along_path("times", page.times.size(), samples);
  if (!std::is_sorted(page.times.begin(), page.times.end())) refuse("times decrease");

  Json out{{"samples", samples}, {"times", rounded_numbers(page.times, "a time")}};
  Json& bodies = out["bodies"] = Json::array();
  for (const PageBody& body : page.bodies) bodies.push_back(body_json(body, samples));
  Json& obstacles = out["obstacles"] = Json::array();
  for (const PageBody& body : page.obstacles) obstacles.push_back(body_json(body, samples));
  Json& tip = out["tip"] = Json::array();
  for (const PagePoint& point : page.tip) tip.push_back(rounded_numbers(point, "a point of the tip's path"));

  Json& targets = out["targets"] = Json::array();
  for (const PageTarget& target : page.targets) {
    const std::string what = "target '" + target.name + "'";
    targets.push_back({{"name", target.name},
                       {"position", rounded_numbers(target.position, "the position of " + what)},
                       {"tolerance", target.tolerance},
                       {"frame", target.frame ? pose_json(*target.frame, what) : Json()},
                       {"miss", target.miss}});
  }
  Json& touches = out["touches"] = Json::array();
  for (const PageTouch& touch : page.touches) {
    const auto check_index = [](int index, std::size_t count, const char* kind) {
      if (index >= 0 && static_cast<std::size_t>(index) < count) return;
      refuse("something touches " + std::string(kind) + " " + std::to_string(index) + " of " + std::to_string(count));
    };
    check_index(touch.body, page.bodies.size(), "body");
    check_index(touch.other, (touch.obstacle ? page.obstacles : page.bodies).size(),
                touch.obstacle ? "obstacle" : "body");
    touches.push_back({{"body", touch.body},
                       {"obstacle", touch.obstacle},
                       {"other", touch.other},
                       {"position", rounded_numbers(touch.position, "the place of a touch")},
                       {"depth", touch.depth}});
  }
  if (page.region) {
    out["region"] = {{"lower", rounded_numbers(page.region->lower, "the region")},
                     {"upper", rounded_numbers(page.region->upper, "the region")}};
  }
  if (page.base) out["base"] = pose_json(*page.base, "the base");
  Json& milestones = out["milestones"] = Json::array();
  for (const PageMilestone& milestone : page.milestones) {
    if (milestone.sample < 0 || static_cast<std::size_t>(milestone.sample) >= samples) {
      refuse("milestone '" + milestone.name + "' stands at sample " + std::to_string(milestone.sample) + " of " +
             std::to_string(samples));
    }
    milestones.push_back({{"name", milestone.name}, {"sample", milestone.sample}});
  }
  return out;
}

Json facts_json(const Page& page) {
  Json out{{"title", page.title},       {"problem", page.problem},   {"solver", page.solver},
           {"seed", page.seed},         {"command", page.command},   {"score", page.score},
           {"achieved", page.achieved}, {"verified", page.verified}, {"reason", page.reason},
           {"mass", page.mass},         {"seconds", page.seconds},   {"evaluations", page.evaluations}};
  out["clearance"] = page.clearance ? Json(*page.clearance) : Json();
  out["goalError"] = page.goal_error ? Json(*page.goal_error) : Json();
  Json& terms = out["terms"] = Json::array();
  for (const PageTerm& term : page.terms) terms.push_back({{"name", term.name}, {"value", term.value}});
  Json& modules = out["modules"] = Json::array();
  for (const PageModule& module : page.modules) {
    Json parameters = Json::array();
    for (const PageParameter& parameter : module.parameters) {
      parameters.push_back({{"name", parameter.name}, {"value", parameter.value}, {"unit", parameter.unit}});
    }
    modules.push_back({{"type", module.type}, {"parameters", std::move(parameters)}});
  }
  Json& trace = out["trace"] = Json::array();
  for (const PageImprovement& step : page.trace) {
    trace.push_back({{"evaluations", step.evaluations},
                     {"seconds", step.seconds},
                     {"score", step.score},
                     {"achieved", step.achieved}});
  }
  return out;
}

}  // namespace

std::string write_page(const Page& page) {
  const std::string title = markup_safe(page.title.empty() ? "modsearch" : page.title);
  const std::string data = script_safe({{"facts", facts_json(page)}, {"scene", scene_json(page)}});
  const std::pair<std::string_view, std::string_view> parts[] = {{"title", title},
                                                                 {"css", page_assets::css},
                                                                 {"data", data},
                                                                 {"three", page_assets::three},
                                                                 {"orbit_controls", page_assets::orbit_controls},
                                                                 {"script", page_assets::script}};

  return fill_html(page_assets::html, parts);
}

}  // namespace modsearch
