// SPDX-License-Identifier: Apache-2.0
// nmc-info: what a stream says of itself, and whether that is true.
#include <chrono>
#include <vector>

#include "decoder/tool/json_writer.h"
#include "decoder/tool/quantity.h"
#include "decoder/tool/stream_source.h"
#include "decoder/tool/tool_main.h"

namespace {

using namespace nmc;

struct Arguments {
  std::vector<std::string> files;
  std::string json = "off";
  bool lists_layers = false, tests = false, hashes = false;
};

struct LayerReport {
  nmc_layer row{};
  bool is_decoded = false;
  double milliseconds = 0;
  std::uint64_t vertex_count = 0, state_hash = 0, position_hash = 0;
};

struct FileReport {
  std::string file;
  StreamOutcome outcome;
  nmc_error_detail error{};
  std::vector<LayerReport> layers;
  std::vector<nmc_attribute> attributes;
  std::uint64_t peak_memory = 0;
  std::string input_output_error;  // not empty: the file could not be read
  ToolExit exit = ToolExit::kOk;
};

/// Decodes the whole stream when its layers are to be tested or hashed, and otherwise no further than the
/// header.
FileReport examine(const std::string& file, const Arguments& arguments) {
  FileReport report;
  report.file = file;
  StreamReader reader;
  try {
    InputFile input(file);
    const bool decodes = arguments.tests || arguments.hashes || arguments.lists_layers;
    auto start = std::chrono::steady_clock::now();
    StreamVisitor visitor;
    visitor.on_header = [&](const nmc_info& info) {
      report.layers.resize(info.layer_count);
      for (std::uint32_t i = 0; i < info.layer_count; ++i) {
        (void)!nmc_decoder_layer(reader.get(), i, &report.layers[i].row);
      }
      return info.layer_count;  // to the end, so that bytes after it are noticed
    };
    visitor.on_layer = [&](const nmc_layer& row) {
      LayerReport& layer = report.layers[row.index];
      std::uint32_t vertex_count = 0, face_count = 0;
      if (reader.mesh_size(row.level, vertex_count, face_count) == NMC_OK) layer.vertex_count = vertex_count;
      std::vector<float> positions(std::size_t{3} * vertex_count);
      const nmc_status read = reader.read_positions(row.level, std::span<float>(positions));
      layer.is_decoded = read == NMC_OK;
      const auto now = std::chrono::steady_clock::now();
      layer.milliseconds = std::chrono::duration<double, std::milli>(now - start).count();
      if (arguments.hashes) {
        (void)!reader.state_hash(layer.state_hash);
        (void)!reader.position_hash(row.level, layer.position_hash);
      }
      start = std::chrono::steady_clock::now();
    };
    if (decodes) {
      report.outcome = decode_stream(reader, input, visitor);
    } else {
      // The header alone, and then the length of the file against what the table promises.
      std::vector<std::uint8_t> bytes(1 << 17);
      nmc_event event{};
      nmc_status status = NMC_NEED_MORE_INPUT;
      while (status == NMC_NEED_MORE_INPUT) {
        const std::size_t size = input.read(bytes.data(), bytes.size());
        report.outcome.bytes_read += size;
        status = size > 0 ? reader.feed(std::span<const std::uint8_t>(bytes.data(), size)) : reader.finish();
        if (status == NMC_OK) status = reader.next(event);
      }
      report.outcome.status = status;
      if (status == NMC_OK && reader.info(report.outcome.info) == NMC_OK) {
        report.outcome.has_info = true;
        visitor.on_header(report.outcome.info);
      }
      // Only decoding tells how many bytes the attributes take.
      nmc_attribute attribute{};
      const bool has_attributes = status == NMC_OK && reader.attribute(0, attribute) == NMC_OK;
      const auto decode_what_came = [&] {
        while (has_attributes && reader.next(event) == NMC_OK) {
        }
      };
      decode_what_came();
      for (std::size_t size; (size = input.read(bytes.data(), bytes.size())) > 0;) {
        report.outcome.bytes_read += size;
        if (has_attributes) (void)!reader.feed(std::span<const std::uint8_t>(bytes.data(), size));
        decode_what_came();
      }
      if (status == NMC_OK) {
        for (const LayerReport& layer : report.layers) {
          report.outcome.layers_complete += layer.row.end_offset <= report.outcome.bytes_read;
        }
      }
    }
    report.error = reader.error();
    if (report.outcome.status == NMC_OK && report.outcome.has_info) {
      if (report.outcome.bytes_read < report.outcome.info.stream_size) {
        report.outcome.status = NMC_ERR_TRUNCATED;
        report.error = {NMC_ERR_TRUNCATED, report.outcome.bytes_read, 0, "3.2", "the stream ends early"};
      } else if (report.outcome.bytes_read > report.outcome.info.stream_size) {
        report.outcome.status = NMC_ERR_CORRUPT;
        report.error = {NMC_ERR_CORRUPT, report.outcome.info.stream_size, 0, "3.2",
                        "bytes follow the last layer"};
      }
    }
    (void)!nmc_decoder_memory(reader.get(), nullptr, &report.peak_memory);
    nmc_attribute attribute{};
    while (report.outcome.has_info &&
           reader.attribute(static_cast<std::uint32_t>(report.attributes.size()), attribute) == NMC_OK)
      report.attributes.push_back(attribute);
    report.exit = exit_code_of(report.outcome.status);
    if (report.exit == ToolExit::kCutOff && report.outcome.layers_complete == 0)
      report.exit = ToolExit::kInvalidInput;
  } catch (const ToolError& error) {
    report.input_output_error = error.what();
    report.exit = error.code();
  }
  return report;
}

std::string kind_name(const nmc_attribute& attribute) {
  return attribute.kind == NMC_ATTRIBUTE_COLOR ? "colour" : "kind " + std::to_string(attribute.kind);
}

void write_json(JsonWriter& json, const FileReport& report, const Arguments& arguments) {
  const nmc_info& info = report.outcome.info;
  json.begin('{');
  json.member("schema", "nmc-info-v1");
  json.member("file", report.file);
  json.member("valid", report.exit == ToolExit::kOk);
  if (!report.input_output_error.empty()) {
    json.key("error").begin('{');
    json.member("status", "INPUT_OUTPUT");
    json.member("message", report.input_output_error);
    json.end('}');
    json.end('}');
    return;
  }
  json.member("bytes", report.outcome.bytes_read);
  if (report.exit != ToolExit::kOk) {
    json.key("error").begin('{');
    json.member("status", nmc_status_name(report.error.status));
    json.member("offset", report.error.byte_offset);
    json.member("section", report.error.spec_section);
    json.member("message", report.error.message);
    json.end('}');
  }
  if (report.outcome.has_info) {
    json.member("format", nmc_format_version());
    json.member("headerBytes", info.header_size);
    json.member("streamBytes", info.stream_size);
    json.member("units", units_name(info.units));
    json.member("up", info.up_axis == NMC_UP_Y ? "y" : info.up_axis == NMC_UP_Z ? "z" : "");
    json.key("bbox").begin('{');
    for (const auto& [name, corner] : {std::pair("min", info.box_min), std::pair("max", info.box_max)}) {
      json.key(name).begin('[');
      for (int k = 0; k < 3; ++k) json.value(corner[k]);
      json.end(']');
    }
    json.end('}');
    json.member("diagonal", info.diagonal);
    json.member("gridStep", info.grid_step);
    json.key("input").begin('{');
    json.member("vertices", info.input_vertex_count);
    json.member("triangles", info.input_triangle_count);
    json.end('}');
    json.key("base").begin('{');
    json.member("vertices", info.base_vertex_count);
    json.member("triangles", info.base_face_count);
    json.member("creases", info.has_creases != 0);
    json.end('}');
    json.member("levels", info.level_count);
    json.member("qualityLayers", info.quality_layer_count);
    json.member("color", info.has_colors != 0);
    json.key("attributes").begin('[');
    for (const nmc_attribute& attribute : report.attributes) {
      json.begin('{');
      json.member("kind", kind_name(attribute));
      json.member("components", attribute.component_count);
      json.member("bits", attribute.bit_count);
      json.member("finestLevel", attribute.finest_level);
      json.member("levelsComplete", attribute.levels_complete);
      json.member("bytes", attribute.byte_count);
      json.end('}');
    }
    json.end(']');
    json.member("layersComplete", report.outcome.layers_complete);
    json.key("layers").begin('[');
    for (const LayerReport& layer : report.layers) {
      json.begin('{');
      json.member("index", layer.row.index);
      json.member("level", layer.row.level);
      json.member("endByte", layer.row.end_offset);
      json.member("triangles", layer.row.face_count);
      if (layer.row.region >= 0) json.member("region", layer.row.region);
      if (layer.row.has_error) {
        json.member("maxError", layer.row.max_error);
        json.member("rmsError", layer.row.rms_error);
      }
      if (layer.is_decoded) {
        json.member("vertices", layer.vertex_count);
        json.member("decodeMs", layer.milliseconds);
      }
      if (layer.is_decoded && arguments.hashes) {
        json.member("stateHash", hash_text(layer.state_hash));
        json.member("positionHash", hash_text(layer.position_hash));
      }
      json.end('}');
    }
    json.end(']');
    if (arguments.tests || arguments.hashes) json.member("peakMemoryBytes", report.peak_memory);
  }
  json.end('}');
}

void print_layers(const FileReport& report, const Arguments& arguments) {
  std::printf("  %5s %5s %4s %12s %12s %12s %12s %9s%s\n", "layer", "level", "", "bytes", "triangles", "max error",
              "rms error", "ms", arguments.hashes ? "  state            positions" : "");
  for (const LayerReport& layer : report.layers) {
    const nmc_layer& row = layer.row;
    const std::string region = row.region >= 0 ? "r" + std::to_string(row.region) : "";
    std::printf("  %5u %5u %4s %12llu %12llu ", row.index, row.level, region.c_str(),
                static_cast<unsigned long long>(row.end_offset),
                static_cast<unsigned long long>(row.face_count));
    if (row.has_error) {
      std::printf("%12.4g %12.4g ", row.max_error, row.rms_error);
    } else {
      std::printf("%12s %12s ", "-", "-");
    }
    if (!layer.is_decoded) {
      std::printf("%9s\n", "missing");
      continue;
    }
    std::printf("%9.1f", layer.milliseconds);
    if (arguments.hashes) {
      std::printf("  %s %s", hash_text(layer.state_hash).c_str(), hash_text(layer.position_hash).c_str());
    }
    std::printf("\n");
  }
}

void print_text(const FileReport& report, const Arguments& arguments) {
  if (!report.input_output_error.empty()) {
    std::fprintf(stderr, "nmc-info: %s\n", report.input_output_error.c_str());
    return;
  }
  const nmc_info& info = report.outcome.info;
  if (report.outcome.has_info) {
    std::printf("%s: %s, %u levels over a base mesh of %u triangles\n", report.file.c_str(),
                bytes_text(report.outcome.bytes_read).c_str(), info.level_count, info.base_face_count);
    if (info.input_triangle_count > 0) {
      std::printf("  input      %llu vertices, %llu triangles (%.2f bits per vertex)\n",
                  static_cast<unsigned long long>(info.input_vertex_count),
                  static_cast<unsigned long long>(info.input_triangle_count),
                  8 * static_cast<double>(info.stream_size) / static_cast<double>(info.input_vertex_count));
    }
    std::printf("  box        %g %g %g to %g %g %g%s%s\n", info.box_min[0], info.box_min[1], info.box_min[2],
                info.box_max[0], info.box_max[1], info.box_max[2], *units_name(info.units) ? " " : "",
                units_name(info.units));
    const nmc_layer& last = report.layers.back().row;
    std::printf("  finest     %llu triangles", static_cast<unsigned long long>(last.face_count));
    if (last.has_error) {
      std::printf(", max error %s (%.4f %% of the diagonal), rms %s",
                  length_text(last.max_error, info.units).c_str(), 100 * last.max_error / info.diagonal,
                  length_text(last.rms_error, info.units).c_str());
    }
    std::printf("\n  first mesh %llu triangles at %s, %u of %u layers present\n",
                static_cast<unsigned long long>(report.layers.front().row.face_count),
                bytes_text(report.layers.front().row.end_offset).c_str(), report.outcome.layers_complete,
                info.layer_count);
    for (const nmc_attribute& attribute : report.attributes) {
      std::printf(
          "  %-10s %u components of %u bits up to level %u, %s (%.0f %% of the stream), %u of %u levels "
          "present\n",
          kind_name(attribute).c_str(), attribute.component_count, attribute.bit_count,
          attribute.finest_level, bytes_text(attribute.byte_count).c_str(),
          100 * static_cast<double>(attribute.byte_count) / static_cast<double>(info.stream_size),
          attribute.levels_complete, attribute.finest_level + 1);
    }
    if (arguments.lists_layers || arguments.hashes) print_layers(report, arguments);
  }
  if (report.exit != ToolExit::kOk) {
    std::fprintf(stderr, "nmc-info: %s: %s\n", report.file.c_str(), error_text(report.error).c_str());
  } else if (arguments.tests) {
    std::printf("%s: ok\n", report.file.c_str());
  }
}

ToolExit show(const Arguments& arguments) {
  ToolExit worst = ToolExit::kOk;
  JsonWriter json(arguments.json == "mini");
  const bool is_list = arguments.files.size() > 1;
  if (is_list) json.begin('[');
  for (const std::string& file : arguments.files) {
    const FileReport report = examine(file, arguments);
    if (worst == ToolExit::kOk) worst = report.exit;
    if (arguments.json == "off") {
      print_text(report, arguments);
    } else {
      write_json(json, report, arguments);
    }
  }
  if (is_list) json.end(']');
  if (arguments.json != "off") std::printf("%s\n", json.text().c_str());
  return worst;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Shows what .nmc streams hold.", "nmc-info");
  app.set_version_flag("-V,--version", version_line("nmc-info"));
  app.add_option("FILE", arguments.files, ".nmc files, or - for standard input")->required();
  app.add_flag("--json{full}", arguments.json,
               "JSON (schema nmc-info-v1), valid for broken files too; --json=mini on one line")
      ->check(CLI::IsMember({"off", "full", "mini"}));
  app.add_flag("--layers", arguments.lists_layers, "a table of all layers");
  app.add_flag("--test", arguments.tests, "decode everything, write nothing");
  app.add_flag("--hash", arguments.hashes, "hashes of the decoded integers and positions of each layer");
  return run_tool(app, argc, argv, [&] { return show(arguments); });
}
