#include "named_visitor.hpp"
#include "sgraph_slam/core/params/params_io.hpp"

namespace sgraph {
namespace {

// Plain where YAML reads plain text as the same text, else in double quotes.
std::string yaml_text(const std::string& text) {
  const std::string plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+";
  const bool word = text != "null" && text != "Null" && text != "NULL";
  if (!text.empty() && text.front() != '-' && word && text.find_first_not_of(plain) == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n') {
      quoted += "\\n";
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

class YamlPrinter : public NamedVisitor {
 public:
  void field(const char* name, double& value, const char* unit, Range, const char*) override { line(name, number_text(value), unit); }
  void field(const char* name, int& value, const char* unit, Range, const char*) override { line(name, std::to_string(value), unit); }
  void field(const char* name, bool& value, const char*) override { line(name, value ? "true" : "false", ""); }
  void field(const char* name, std::string& value, const char*) override { line(name, yaml_text(value), ""); }
  void choice(const char* name, std::string& value, const std::vector<std::string>& options, const char*) override {
    std::string list;
    for (const std::string& option : options) list += (list.empty() ? "" : " | ") + option;
    line(name, yaml_text(value), list);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 protected:
  void enter(const char* name, const char* text) override {
    if (depth() == 1 && !text_.empty()) text_ += '\n';
    const std::string indent(2 * static_cast<std::size_t>(depth() - 1), ' ');
    text_ += indent + "# " + text + '\n' + indent + name + ":\n";
  }

 private:
  void line(const char* name, const std::string& value, const std::string& note) {
    text_ += std::string(2 * static_cast<std::size_t>(depth()), ' ') + name + ": " + value + (note.empty() ? "" : "  # " + note) + '\n';
  }

  std::string text_;
};

class MarkdownPrinter : public NamedVisitor {
 public:
  void field(const char* name, double& value, const char* unit, Range range, const char* text) override {
    row(name, number_text(value), unit, interval(range), text);
  }
  void field(const char* name, int& value, const char* unit, Range range, const char* text) override {
    row(name, std::to_string(value), unit, interval(range), text);
  }
  void field(const char* name, bool& value, const char* text) override { row(name, value ? "true" : "false", "", "true, false", text); }
  void field(const char* name, std::string& value, const char* text) override { row(name, value, "", "text", text); }
  void choice(const char* name, std::string& value, const std::vector<std::string>& options, const char* text) override {
    std::string list;
    for (const std::string& option : options) list += (list.empty() ? "" : ", ") + option;
    row(name, value, "", list, text);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 protected:
  void enter(const char*, const char* text) override {
    if (!text_.empty()) text_ += '\n';
    text_ += std::string(static_cast<std::size_t>(depth()) + 1, '#') + " `" + group_name() + "`\n\n" + text + '\n';
    table_of_ = "";
  }

 private:
  static std::string interval(Range range) { return number_text(range.low) + " .. " + number_text(range.high); }

  static std::string cell(const std::string& text) {
    std::string escaped;
    for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
    return escaped;
  }

  void row(const char* name, const std::string& value, const std::string& unit, const std::string& range, const char* text) {
    if (const std::string table = full(""); table_of_ != table || text_.empty()) {
      text_ += std::string(text_.empty() ? "" : "\n") + "| name | default | unit | range | meaning |\n|---|---|---|---|---|\n";
      table_of_ = table;
    }
    text_ += "| `" + full(name) + "` | " + cell(value) + " | " + cell(unit) + " | " + cell(range) + " | " + cell(text) + " |\n";
  }

  std::string text_;
  std::string table_of_;  // prefix of the table that is open
};

}  // namespace

std::string to_yaml(const Describe& describe) {
  YamlPrinter printer;
  describe(printer);
  return printer.text();
}

std::string to_markdown(const Describe& describe) {
  MarkdownPrinter printer;
  describe(printer);
  return printer.text();
}

}  // namespace sgraph
