// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "corpus/generate/shapes.h"
#include "encoder/condition/condition.h"

using namespace nmc;
using Catch::Matchers::Contains;

namespace {
ConditionedMesh damaged_sphere() {
  TriangleMesh mesh = corpus::icosphere(3);
  corpus::turn_around(mesh);
  mesh.triangles.push_back(mesh.triangles[5]);
  mesh.triangles.push_back({0, 1, 100000});
  mesh.positions.push_back({7, 7, 7});
  return condition(mesh);
}
}  // namespace

TEST_CASE("condition report: JSON holds every count and parses", "[condition][report]") {
  const nlohmann::json json = nlohmann::json::parse(to_json(damaged_sphere().report));
  CHECK(json["input"]["triangles"] == 1282);
  CHECK(json["repairs"]["needed"] == true);
  CHECK(json["repairs"]["duplicateTriangles"] == 1);
  CHECK(json["repairs"]["outOfRangeTriangles"] == 1);
  CHECK(json["repairs"]["droppedTriangles"] == 2);
  CHECK(json["repairs"]["turnedComponents"] == 1);
  CHECK(json["repairs"]["unreferencedVertices"] == 1);
  CHECK(json["repairs"]["firstCases"].size() == 3);
  CHECK(json["output"]["components"] == 1);
  CHECK(json["output"]["genus"] == 0);
  CHECK(json["output"]["largestComponents"][0]["closed"] == true);
  CHECK(json["output"]["largestComponents"][0]["turnedInsideOut"] == true);
}

TEST_CASE("condition report: JSON lists the largest of many components", "[condition][report]") {
  const ConditionedMesh result = condition(corpus::loose_triangles(500));
  const nlohmann::json json = nlohmann::json::parse(to_json(result.report, 10));
  CHECK(json["output"]["components"] == 500);
  REQUIRE(json["output"]["largestComponents"].size() == 10);
  CHECK(json["output"]["largestComponents"][0]["area"] > json["output"]["largestComponents"][9]["area"]);
  CHECK(json["output"]["longestBoundaryLoops"].size() == 10);
}

TEST_CASE("condition report: text fits a screen and names what was done", "[condition][report]") {
  const std::string text = to_text(damaged_sphere().report);
  CHECK_THAT(text, Contains("stored twice") && Contains("inside out") && Contains("in no triangle") &&
                       Contains("1 component (1 closed), genus 0"));
  CHECK(std::count(text.begin(), text.end(), '\n') <= 24);
  const std::string clean = to_text(condition(corpus::icosphere(2)).report);
  CHECK(std::count(clean.begin(), clean.end(), '\n') == 2);
}
