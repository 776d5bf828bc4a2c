#include "separate_files.hpp"

#include <fmt/format.h>

#include <string>
#include <system_error>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "video/image_list.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::invalid_argument, what); }

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  return fs::equivalent(a, b, failed);
}

/// Also of files that are not there yet; several results may go to one terminal or pipe.
bool same_result(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  if (fs::exists(a, failed)) return fs::is_regular_file(a, failed) && same_file(a, b);
  // Of a relative name of which nothing is there yet, the canonical one is relative too.
  const fs::path whole = fs::weakly_canonical(fs::absolute(a), failed);
  return !failed && whole == fs::weakly_canonical(fs::absolute(b), failed);
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

/// Frames that are files; what is missing or no image is found out by who opens it.
std::vector<fs::path> frame_files(const std::string& input) {
  std::vector<fs::path> files;
  try {
    if (const auto images = list_images(input)) {
      for (const ListedImage& image : *images) files.push_back(image.path);
      return files;
    }
  } catch (const Error&) {
  }
  return {input};
}

void require_distinct(const std::vector<fs::path>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (same_result(files[i], files[j])) {
        refuse(fmt::format("two results would go to '{}': give each a file of its own", files[i].string()));
      }
    }
  }
}

/// A model brings files that nobody named.
void require_not_of_model(const ResultFiles& results) {
  for (const fs::path& model : results.models) {
    for (const fs::path& file : results.files) {
      if (!model.empty() && !file.empty() && io::is_file_of_model(model, file)) {
        refuse(fmt::format("'{}' is where the model '{}' keeps its materials or texture: give the result another name",
                           file.string(), model.string()));
      }
    }
  }
}

/// Images that come to lie among those of a folder are frames of it from then on.
void require_no_new_frame(const fs::path& result, const std::vector<std::string>& frames) {
  if (!is_image_name(result)) return;
  for (const std::string& input : frames) {
    if (same_file(folder_of(result), input)) {
      refuse(fmt::format("'{}' would be one of the frames in '{}': give the result another folder", result.string(),
                         input));
    }
  }
}

}  // namespace

void require_separate_files(const ResultFiles& results, const InputFiles& inputs) {
  std::vector<fs::path> written;
  for (const std::vector<fs::path>* group : {&results.files, &results.models}) {
    for (const fs::path& file : *group) {
      if (!file.empty()) written.push_back(file);
    }
  }
  require_distinct(written);
  require_not_of_model(results);
  for (const fs::path& file : written) require_no_new_frame(file, inputs.frames);

  std::vector<fs::path> replaced;
  std::error_code failed;
  for (const fs::path& file : results.files) {
    if (!file.empty() && fs::exists(file, failed)) replaced.push_back(file);
  }
  for (const fs::path& model : results.models) {
    if (model.empty()) continue;
    const std::vector<fs::path> files = io::replaceable_model_files(model);
    replaced.insert(replaced.end(), files.begin(), files.end());
  }
  if (replaced.empty() && results.folders.empty()) return;

  std::vector<fs::path> read = inputs.files;
  for (const fs::path& model : inputs.models) {
    if (model.empty()) continue;
    const std::vector<fs::path> files = io::model_files(model);
    read.insert(read.end(), files.begin(), files.end());
  }
  for (const std::string& input : inputs.frames) {
    for (const fs::path& frame : frame_files(input)) {
      read.push_back(frame);
      for (const fs::path& folder : results.folders) {
        if (!folder.empty() && same_file(folder, folder_of(frame))) {
          refuse(
              fmt::format("'{}' holds frames of the input: give the results a folder of their own", folder.string()));
        }
      }
    }
  }
  for (const fs::path& input : read) {
    for (const fs::path& result : replaced) {
      if (same_file(result, input)) {
        refuse(fmt::format("'{}' is an input and would be overwritten: give the result another name", result.string()));
      }
    }
  }
}

}  // namespace holdfast::app
