#include "touchstone/examples/compare_backends/page/html.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {

Page::Page(const Report& of) : report(of) {
  for (const auto& backend : report.backends) names.push_back(backend.first);
}

std::string Page::named(const std::string& backend) const {
  return mark_svg(names, backend) + xml_text(backend);
}

HtmlTable::HtmlTable(const std::vector<std::string>& header, const char* style) {
  html_ = std::string("<div class='scroll'><table class='") + style + "'><thead><tr>";
  for (const std::string& cell : header) html_ += "<th>" + cell + "</th>";
  html_ += "</tr></thead><tbody>\n";
}

void HtmlTable::add(const std::vector<std::string>& row, const char* style) {
  html_ += *style ? fmt::format("<tr class='{}'>", style) : "<tr>";
  for (std::size_t i = 0; i < row.size(); ++i)
    html_ += i == 0 ? "<th>" + row[i] + "</th>" : "<td>" + xml_text(row[i]) + "</td>";
  html_ += "</tr>\n";
}

void HtmlTable::add_markup(const std::vector<std::string>& row) {
  html_ += "<tr>";
  for (std::size_t i = 0; i < row.size(); ++i)
    html_ += i == 0 ? "<th>" + row[i] + "</th>" : "<td>" + row[i] + "</td>";
  html_ += "</tr>\n";
}

std::string filled(std::string_view text, const std::map<std::string_view, std::string>& values) {
  std::string page;
  for (std::size_t open; (open = text.find("{{")) != std::string_view::npos;) {
    const std::size_t close = text.find("}}", open);
    page += text.substr(0, open);
    page += values.at(text.substr(open + 2, close - open - 2));
    text.remove_prefix(close + 2);
  }
  return page.append(text);
}

std::string source_note(const std::string& json_path, const std::string& svg) {
  std::string html =
      "<p class='source'>Data: <code>results.json</code>, <code>" + xml_text(json_path) + "</code>";
  if (!svg.empty()) html += "; SVG: <code>" + xml_text(svg) + "</code>";
  return html + "</p>\n";
}

std::string blocks_text(const Report& report) {
  std::size_t least = 0, most = 0;
  for (const SetResult& set : report.sets) {
    for (const BackendResult& backend : set.backends) {
      for (const BackendResult::Rows& rows : backend.rows) {
        for (const auto* timing : {&rows.single, &rows.cached, &rows.batch, &rows.raw}) {
          if (!*timing) continue;
          least = least == 0 ? (*timing)->block : std::min(least, (*timing)->block);
          most = std::max(most, (*timing)->block);
        }
      }
    }
  }
  const std::string pairs =
      least == most ? format_count(most) : format_count(least) + " to " + format_count(most);
  return "the averages of blocks of " + pairs + " pairs, not of single queries";
}

std::string wrong_lines(const Wrongness& wrong, const char* between) {
  std::string text;
  for (const auto& [count, name] : wrong.kinds()) {
    if (count > 0)
      text += fmt::format("{}<span class='n'>{} {}</span>", text.empty() ? "" : between, format_count(count),
                          name);
  }
  return text;
}

}  // namespace touchstone::comparison
