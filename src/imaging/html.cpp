// Parts of an HTML report that needs nothing but itself: style inside, images as data, no script.
#include "imaging/html.h"

#include "imaging/page_html.h" // kPage, made from page.html
#include "scene/image_decode.h"

#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

std::string base64(const Bytes& bytes) {
    constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto byte = [&](std::size_t k) { return i + k < bytes.size() ? std::uint32_t(bytes[i + k]) : 0u; };
        const std::uint32_t group = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (int k = 0; k < 4; ++k)
            text += i + std::size_t(k) <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

} // namespace

std::string escapeHtml(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '&')
            result += "&amp;";
        else if (c == '<')
            result += "&lt;";
        else if (c == '>')
            result += "&gt;";
        else if (c == '"')
            result += "&quot;";
        else if (static_cast<unsigned char>(c) >= 0x20)
            result += c;
    }
    return result;
}

std::string pngDataUri(const Image& image) { return "data:image/png;base64," + base64(encodePng(image)); }

std::string svgImage(const std::string& svg) {
    return "<img alt=\"\" src=\"data:image/svg+xml;base64," + base64(Bytes(svg.begin(), svg.end())) + "\">";
}

std::string htmlFigures(const std::vector<HtmlFigure>& figures) {
    constexpr int kSmall = 160; // narrower images are enlarged without blurring their texels
    std::string html = "<div class=\"figures\">\n";
    for (const HtmlFigure& figure : figures)
        html += std::string("<figure><img alt=\"\"") + (figure.image.width < kSmall ? " class=\"small\"" : "") + " src=\"" +
                pngDataUri(figure.image) + "\"><figcaption>" + figure.caption + "</figcaption></figure>\n";
    return html + "</div>\n";
}

std::string htmlTable(const HtmlTable& table) {
    std::string html = "<div class=\"scroll\"><table>\n<thead><tr>";
    for (const auto& column : table.columns)
        html += "<th" + (column.meaning.empty() ? "" : " title=\"" + escapeHtml(column.meaning) + "\"") + ">" + escapeHtml(column.name) +
                "</th>";
    html += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        html += "<tr>";
        for (const std::string& cell : row)
            html += "<td>" + cell + "</td>";
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

std::string htmlDocument(const std::string& title, const std::string& body) {
    std::string page = kPage;
    const auto put = [&](const std::string& mark, const std::string& text) { page.replace(page.find(mark), mark.size(), text); };
    put("{{title}}", escapeHtml(title));
    put("{{body}}", body);
    return page;
}

std::string shortNumber(double value) {
    if (!std::isfinite(value))
        return "&ndash;";
    char text[32];
    std::snprintf(text, sizeof text, std::abs(value) >= 1000 && std::abs(value) < 1e6 ? "%.0f" : "%.3g", value);
    return text;
}

std::string withError(double value, double error) {
    if (!std::isfinite(value))
        return "&ndash;";
    if (!(error > 0) || !std::isfinite(error))
        return shortNumber(value);
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", error);
    return shortNumber(value) + " <small>&plusmn;&nbsp;" + text + "</small>";
}

} // namespace cmpg
