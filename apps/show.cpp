#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "init/check_picture.hpp"
#include "messages.hpp"
#include "separate_files.hpp"
#include "show/model_sheet.hpp"
#include "track/output_file.hpp"

namespace holdfast {
namespace {

struct ShowCommand {
  app::ModelArguments model;
  std::filesystem::path out;
  RendererChoice renderer = RendererChoice::automatic;
  std::filesystem::path config;

  void run() const {
    if (!out.empty()) {
      app::require_separate_files({{out}, {}, {}}, {{config}, {}, {model.path}});
      app::require_writable(out);
    }
    const Mesh mesh = model.load();
    app::warn_about_units(mesh);
    app::warn_if(app::model_doubt(mesh));
    if (!out.empty()) app::save_picture(out, app::model_sheet(mesh, model.path.filename().string(), renderer));
    fmt::print("{}", app::model_text(mesh));
    if (!out.empty()) fmt::print("written        {}\n", out.string());
  }
};

}  // namespace

void add_show_command(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand("show", "Draw a model as it is read, from six sides, with its axes and size");
  const auto show = std::make_shared<ShowCommand>();
  command->add_option("MODEL", show->model.path, "Model: OBJ, PLY, OFF, glTF or anything else that assimp reads")
      ->required()
      ->type_name("FILE");
  command->add_option("--model-scale", show->model.scale, "The model's unit in metres: 0.001 for millimetres")
      ->capture_default_str()
      ->type_name("FACTOR");
  command->add_option("-o,--picture", show->out, "The picture (.png, .jpg)")->type_name("FILE");
  app::add_renderer_option(*command, show->renderer);
  app::add_config_option(*command);
  command->callback([command, show] {
    show->config = app::config_file(*command);
    show->run();
  });
}

}  // namespace holdfast
