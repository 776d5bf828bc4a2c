#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "driver_start.hpp"
#include "exit_codes.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"
#include "holdfast/renderer.hpp"
#include "messages.hpp"

namespace holdfast {
namespace {

using app::DeviceArguments;

/// What the machine has, and what it lacks.
struct Inventory {
  std::vector<DeviceInfo> devices;
  std::optional<DeviceInfo> used;
  std::optional<std::string> renderer;
  std::string renderer_reason;
  std::vector<std::string> missing;  ///< in words, with the package to install
};

/// The least that can be drawn.
Mesh triangle() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}};
  mesh.colors = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

/// Opens the device, so that one which cannot compile Holdfast's kernels is not reported as good.
Inventory take_inventory(const DeviceArguments& arguments) {
  Inventory inventory;
  app::start_drivers();
  inventory.devices = Device::list();
  try {
    inventory.used = arguments.open().info();
  } catch (const Error& error) {
    inventory.missing.push_back(error.what());
  }
  try {
    RendererOptions options;
    options.choice = arguments.options.renderer;
    const Renderer renderer(triangle(), 16, 16, options);
    inventory.renderer = renderer.description();
    inventory.renderer_reason = renderer.reason();
  } catch (const Error& error) {
    inventory.missing.push_back(error.what());
  }
  return inventory;
}

std::string address(const DeviceInfo& device) {
  return fmt::format("{}:{}", device.platform_index, device.device_index);
}

bool is_used(const DeviceInfo& device, const Inventory& inventory) {
  return inventory.used && address(*inventory.used) == address(device);
}

nlohmann::ordered_json to_json(const DeviceInfo& device, const Inventory& inventory) {
  const bool used = is_used(device, inventory);
  return {{"address", address(device)},
          {"type", device.type},
          {"name", device.name},
          {"version", device.version},
          {"driver", device.driver},
          {"compute_units", device.compute_units},
          {"platform", device.platform},
          {"platform_version", device.platform_version},
          {"usable", device.usable},
          {"used", used},
          {"reason", used            ? inventory.used->reason
                     : device.usable ? ""
                                     : device.reason}};
}

void print_json(const Inventory& inventory) {
  nlohmann::ordered_json document;
  document["devices"] = nlohmann::ordered_json::array();
  for (const DeviceInfo& device : inventory.devices) {
    document["devices"].push_back(to_json(device, inventory));
  }
  document["used"] = inventory.used ? nlohmann::ordered_json(address(*inventory.used)) : nullptr;
  document["renderer"] = inventory.renderer ? nlohmann::ordered_json(*inventory.renderer) : nullptr;
  document["renderer_reason"] = inventory.renderer_reason;
  document["missing"] = inventory.missing;
  fmt::print("{}\n", document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

/// PoCL appends how it was built, after two blanks.
std::string without_build_details(const std::string& version) { return version.substr(0, version.find("  ")); }

/// Debian's packages that would bring what there is none of.
std::string packages_to_install(const Inventory& inventory) {
  std::string packages = inventory.devices.empty() ? " pocl-opencl-icd" : "";
  return packages + (inventory.renderer ? "" : " libosmesa6");
}

void print_text(const Inventory& inventory) {
  fmt::print("OpenCL devices\n");
  for (const DeviceInfo& device : inventory.devices) {
    const std::string remark = is_used(device, inventory) ? "  <- used: " + inventory.used->reason
                               : device.usable            ? ""
                                                          : "  not usable: " + device.reason;
    fmt::print("  {:<5} {:<4} {} ({} compute units){}\n", address(device), device.type, device.name,
               device.compute_units, remark);
    fmt::print("             {}: {}, driver {}\n", device.platform, without_build_details(device.platform_version),
               device.driver);
  }
  if (inventory.devices.empty()) {
    fmt::print("  none\n");
  }
  fmt::print("Renderer\n  {}{}\n", inventory.renderer.value_or("none"),
             inventory.renderer ? "  <- used: " + app::one_line(inventory.renderer_reason) : "");
  if (inventory.missing.empty()) {
    fmt::print("Nothing is missing. --device takes an address (0:0), cpu, gpu, or a part of a name.\n");
    return;
  }
  fmt::print("Missing\n");
  for (const std::string& missing : inventory.missing) {
    fmt::print("  {}\n", app::one_line(missing));
  }
  if (const std::string packages = packages_to_install(inventory); !packages.empty()) {
    fmt::print("  On Debian: apt-get install{}\n", packages);
  }
}

}  // namespace

void add_devices_command(CLI::App& app, int& exit_code) {
  struct Arguments {
    DeviceArguments device;
    bool json = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("devices", "List OpenCL devices and the renderer, and what is missing");
  command->add_flag("--json", arguments->json, "Print JSON");
  arguments->device.add_to(*command);
  app::add_config_option(*command);
  command->callback([arguments, &exit_code] {
    const Inventory inventory = take_inventory(arguments->device);
    if (arguments->json) {
      print_json(inventory);
    } else {
      print_text(inventory);
    }
    if (!inventory.missing.empty()) {
      app::print_error(inventory.missing.front());
      exit_code = app::kNoDevice;
    }
  });
}

}  // namespace holdfast
