#include "io/xml_text.hpp"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "io/json_text.hpp"
#include "io/numbers.hpp"

namespace holdfast::io {
namespace {

using nlohmann::json;

constexpr std::string_view kBlanks = " \t\r\n";

std::string with_entities(std::string_view text) {
  constexpr std::pair<std::string_view, char> entities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string plain;
  while (!text.empty()) {
    bool replaced = false;
    for (const auto& [name, character] : entities) {
      if (text.starts_with(name)) {
        plain += character;
        text.remove_prefix(name.size());
        replaced = true;
        break;
      }
    }
    if (!replaced) {
      plain += text.front();
      text.remove_prefix(1);
    }
  }
  return plain;
}

/// What stands between two tags without others.
json value_of(std::string_view text) {
  std::vector<double> numbers;
  std::string_view rest = text;
  while (true) {
    rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
    if (rest.empty()) break;
    const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
    rest.remove_prefix(word.size());
    const std::optional<double> number = parse_number(word);
    if (!number) {
      const std::size_t first = text.find_first_not_of(kBlanks), last = text.find_last_not_of(kBlanks);
      text = text.substr(first, last - first + 1);
      const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
      return with_entities(quoted ? text.substr(1, text.size() - 2) : text);
    }
    numbers.push_back(*number);
  }
  if (numbers.empty()) return nullptr;
  return numbers.size() == 1 ? json(numbers.front()) : json(numbers);
}

class XmlReader {
 public:
  explicit XmlReader(std::string_view text) : rest_(text) {}

  json read() {
    if (!skip_to_tag()) throw std::runtime_error("it has no element");
    const Tag root = take_tag();
    return root.is_whole ? json(nullptr) : content(root.name, 1);
  }

 private:
  struct Tag {
    std::string name;
    bool is_whole = false;  ///< <name/>
  };

  void take_until(std::string_view mark) {
    const std::size_t end = rest_.find(mark);
    if (end == rest_.npos) throw std::runtime_error(fmt::format("there is no '{}' to what is begun", mark));
    rest_.remove_prefix(end + mark.size());
  }

  /// Moves on to the next tag of an element, opening or closing; what stands before it is kept in text_.
  bool skip_to_tag() {
    text_ = {};
    while (true) {
      const std::size_t at = rest_.find('<');
      if (at == rest_.npos) return false;
      if (text_.find_first_not_of(kBlanks) == text_.npos) text_ = rest_.substr(0, at);
      rest_.remove_prefix(at);
      if (rest_.starts_with("<!--")) {
        take_until("-->");
      } else if (rest_.starts_with("<?")) {
        take_until("?>");
      } else if (rest_.starts_with("<!")) {
        throw std::runtime_error("document types and literal sections are not supported");
      } else {
        return true;
      }
    }
  }

  Tag take_tag() {
    rest_.remove_prefix(1);
    Tag tag{std::string(rest_.substr(0, rest_.find_first_of(" \t\r\n/>"))), false};
    rest_.remove_prefix(tag.name.size());
    if (tag.name.empty()) throw std::runtime_error("an element has no name");
    for (char quote = 0; !rest_.empty(); rest_.remove_prefix(1)) {  // over the attributes
      const char c = rest_.front();
      if (quote == 0 && (c == '>' || rest_.starts_with("/>"))) {
        tag.is_whole = c == '/';
        rest_.remove_prefix(tag.is_whole ? 2 : 1);
        return tag;
      }
      quote = quote == 0 && (c == '"' || c == '\'') ? c : c == quote ? '\0' : quote;
    }
    throw std::runtime_error(fmt::format("the tag '{}' has no end", tag.name.substr(0, 40)));
  }

  /// What an element holds, up to its end.
  json content(const std::string& name, int depth) {
    if (depth > kMostNested) throw std::runtime_error("its elements are nested too deeply");
    json map = json::object(), list = json::array();
    while (true) {
      if (!skip_to_tag()) throw std::runtime_error(fmt::format("the element '{}' has no end", name.substr(0, 40)));
      if (rest_.starts_with("</")) {
        const std::string_view text = text_;
        rest_.remove_prefix(2);
        const std::string_view end = rest_.substr(0, rest_.find_first_of(" \t\r\n>"));
        if (end != name)
          throw std::runtime_error(fmt::format("'{}' ends as '{}'", name.substr(0, 40), end.substr(0, 40)));
        take_until(">");
        if (!list.empty()) return list;
        return map.empty() ? value_of(text) : map;
      }
      const Tag child = take_tag();
      json value = child.is_whole ? json(nullptr) : content(child.name, depth + 1);
      if (child.name == "_") {
        list.push_back(std::move(value));
      } else {
        map[child.name] = std::move(value);
      }
    }
  }

  std::string_view rest_;
  std::string_view text_;  ///< before the tag that is next
};

}  // namespace

json parse_xml_text(std::string_view text) { return XmlReader(text).read(); }

}  // namespace holdfast::io
