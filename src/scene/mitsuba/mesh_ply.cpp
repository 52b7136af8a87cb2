// Stanford PLY files: text, or binary of either byte order.
#include "scene/mitsuba/mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

namespace cmpg {
namespace {

constexpr std::size_t kMaxHeader = 1 << 16; // bytes

enum class Number : std::uint8_t { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };
constexpr std::array<std::size_t, 8> kNumberBytes = {1, 1, 2, 2, 4, 4, 4, 8};

struct Property {
    std::string name;
    Number type;
    std::optional<Number> count; // of a list: what its length is written as
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Encoding { Text, LittleEndian, BigEndian };

class PlyReader {
  public:
    PlyReader(const Bytes& file, const std::string& name) : at_(file.data()), end_(at_ + file.size()), name_(name) {}
    Mesh run();

  private:
    [[noreturn]] void fail(const std::string& what) const { failMesh(name_, what); }
    void readHeader();
    void readVertices(const Element& element);
    void readFaces(const Element& element);
    void skip(const Element& element);
    void requireRoom(std::uint64_t count, std::uint64_t bytes) const;
    std::uint64_t fewestBytes(const Element& element) const;
    double number(Number type);
    std::uint64_t length(Number type, Number of);
    void skip(const Property& property);

    const std::uint8_t *at_, *end_;
    const std::string& name_;
    Encoding encoding_ = Encoding::Text;
    std::vector<Element> elements_;
    Mesh mesh_;
};

bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::vector<std::string_view> words(std::string_view line) {
    std::vector<std::string_view> found;
    for (std::size_t i = 0; i < line.size();) {
        const std::size_t begin = i;
        while (i < line.size() && !isSpace(line[i]))
            ++i;
        if (i > begin)
            found.push_back(line.substr(begin, i - begin));
        else
            ++i;
    }
    return found;
}

std::optional<Number> numberOf(std::string_view word) {
    constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"}, {"ushort", "uint16"},
                                                                       {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}}};
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (word == kNames[i][0] || word == kNames[i][1])
            return Number(i);
    return {};
}

void PlyReader::readHeader() {
    const std::uint8_t* const limit = at_ + std::min<std::size_t>(std::size_t(end_ - at_), kMaxHeader);
    const auto nextLine = [&] {
        const std::uint8_t* const ending = std::find(at_, limit, std::uint8_t('\n'));
        if (ending == limit)
            fail("is no PLY: its header has no end within " + std::to_string(kMaxHeader) + " bytes");
        const std::string_view line(reinterpret_cast<const char*>(at_), std::size_t(ending - at_));
        at_ = ending + 1;
        return line;
    };
    if (words(nextLine()) != std::vector<std::string_view>{"ply"})
        fail("is no PLY: it does not begin with that word");
    bool encoded = false;
    for (;;) {
        const std::string_view text = nextLine();
        const std::vector<std::string_view> line = words(text);
        const auto bad = [&] {
            std::string message = "the header's line \"";
            message += text.substr(0, 96);
            message += "\" is not understood";
            fail(message);
        };
        if (line.empty() || line[0] == "comment" || line[0] == "obj_info")
            continue;
        if (line[0] == "end_header")
            break;
        if (line[0] == "format" && line.size() == 3 && line[2] == "1.0" && !encoded) {
            constexpr std::array<std::string_view, 3> kNames = {"ascii", "binary_little_endian", "binary_big_endian"};
            const auto found = std::find(kNames.begin(), kNames.end(), line[1]);
            if (found == kNames.end())
                bad();
            encoding_ = Encoding(found - kNames.begin());
            encoded = true;
        } else if (line[0] == "element" && line.size() == 3) {
            Element& element = elements_.emplace_back();
            element.name = line[1];
            const auto [ending, error] = std::from_chars(line[2].begin(), line[2].end(), element.count);
            if (error != std::errc() || ending != line[2].end())
                bad();
        } else if (line[0] == "property" && !elements_.empty() && (line.size() == 3 || (line.size() == 5 && line[1] == "list"))) {
            const bool list = line.size() == 5;
            const std::optional<Number> type = numberOf(line[list ? 3 : 1]), count = list ? numberOf(line[2]) : std::nullopt;
            if (!type || (list && (!count || *count >= Number::Float32)))
                bad();
            elements_.back().properties.push_back({std::string(line.back()), *type, count});
        } else {
            bad();
        }
    }
    if (!encoded)
        fail("the header names no format");
}

// So many things of so many bytes at least must still be there; before memory is taken for them.
void PlyReader::requireRoom(std::uint64_t count, std::uint64_t bytes) const {
    const std::uint64_t left = std::uint64_t(end_ - at_) + 1; // the last number of a text needs no space after it
    if (bytes > 0 && count > left / bytes)
        fail("it ends early");
}

std::uint64_t PlyReader::fewestBytes(const Element& element) const {
    std::uint64_t sum = 0;
    for (const Property& p : element.properties)
        sum += encoding_ == Encoding::Text ? 2 : kNumberBytes[std::size_t(p.count.value_or(p.type))];
    return sum;
}

double PlyReader::number(Number type) {
    if (encoding_ == Encoding::Text) {
        while (at_ < end_ && isSpace(char(*at_)))
            ++at_;
        if (at_ < end_ && *at_ == '+')
            ++at_;
        double value = 0;
        const char* const begin = reinterpret_cast<const char*>(at_);
        const char* const limit = reinterpret_cast<const char*>(end_);
        const auto [ending, error] = std::from_chars(begin, limit, value);
        const bool whole = ending > begin && (ending == limit || isSpace(*ending));
        if (begin == limit)
            fail("it ends early");
        if (!whole || error != std::errc())
            fail("what stands where a number should is none, or too large or small for one");
        at_ = reinterpret_cast<const std::uint8_t*>(ending);
        return value;
    }
    const std::size_t bytes = kNumberBytes[std::size_t(type)];
    if (std::size_t(end_ - at_) < bytes)
        fail("it ends early");
    std::array<std::uint8_t, 8> b{};
    std::copy_n(at_, bytes, b.begin());
    at_ += bytes;
    if ((encoding_ == Encoding::BigEndian) == (std::endian::native == std::endian::little))
        std::reverse(b.begin(), b.begin() + std::ptrdiff_t(bytes));
    const auto as = [&](auto value) {
        std::memcpy(&value, b.data(), sizeof value);
        return double(value);
    };
    switch (type) {
    case Number::Int8: return as(std::int8_t());
    case Number::Uint8: return as(std::uint8_t());
    case Number::Int16: return as(std::int16_t());
    case Number::Uint16: return as(std::uint16_t());
    case Number::Int32: return as(std::int32_t());
    case Number::Uint32: return as(std::uint32_t());
    case Number::Float32: return as(float());
    case Number::Float64: return as(double());
    }
    return 0;
}

// Of a list whose entries are of type `of`.
std::uint64_t PlyReader::length(Number type, Number of) {
    const double value = number(type);
    if (!(value >= 0 && value <= std::numeric_limits<std::uint32_t>::max() && value == double(std::uint64_t(value))))
        fail("a list has a length that is no count");
    requireRoom(std::uint64_t(value), encoding_ == Encoding::Text ? 2 : kNumberBytes[std::size_t(of)]);
    return std::uint64_t(value);
}

void PlyReader::skip(const Property& property) {
    for (std::uint64_t left = property.count ? length(*property.count, property.type) : 1; left > 0; --left)
        number(property.type);
}

void PlyReader::skip(const Element& element) {
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i)
        for (const Property& p : element.properties)
            skip(p);
}

void PlyReader::readVertices(const Element& element) {
    // Where each property goes: x y z, nx ny nz, u v; Mitsuba takes s and t for the last, too.
    constexpr std::array<std::string_view, 8> kNames = {"x", "y", "z", "nx", "ny", "nz", "u", "v"};
    constexpr std::size_t kElsewhere = kNames.size();
    std::vector<std::size_t> places;
    std::array<bool, kNames.size()> given{};
    for (const Property& p : element.properties) {
        const std::string_view name = p.name == "s" ? "u" : p.name == "t" ? "v" : std::string_view(p.name);
        const auto place = std::size_t(std::find(kNames.begin(), kNames.end(), name) - kNames.begin());
        const bool wanted = place < kElsewhere && !p.count && !given[place];
        places.push_back(wanted ? place : kElsewhere);
        if (wanted)
            given[place] = true;
    }
    if (!(given[0] && given[1] && given[2]))
        fail("its vertices have no x, y and z");
    const bool normals = given[3] && given[4] && given[5], uvs = given[6] && given[7];
    mesh_.positions.reserve(element.count);
    mesh_.normals.reserve(normals ? element.count : 0);
    mesh_.uvs.reserve(uvs ? element.count : 0);
    for (std::uint64_t i = 0; i < element.count; ++i) {
        std::array<double, kNames.size()> v{};
        for (std::size_t p = 0; p < places.size(); ++p) {
            if (places[p] == kElsewhere)
                skip(element.properties[p]);
            else
                v[places[p]] = number(element.properties[p].type);
        }
        mesh_.positions.emplace_back(v[0], v[1], v[2]);
        if (normals)
            mesh_.normals.emplace_back(v[3], v[4], v[5]);
        if (uvs)
            mesh_.uvs.emplace_back(v[6], v[7]);
    }
}

void PlyReader::readFaces(const Element& element) {
    const auto isCorners = [](const Property& p) { return p.count && (p.name == "vertex_indices" || p.name == "vertex_index"); };
    const auto corners = std::find_if(element.properties.begin(), element.properties.end(), isCorners);
    if (corners == element.properties.end())
        fail("its faces have no list vertex_indices");
    mesh_.triangles.reserve(element.count);
    std::vector<std::uint32_t> polygon;
    for (std::uint64_t i = 0; i < element.count; ++i)
        for (auto p = element.properties.begin(); p != element.properties.end(); ++p) {
            if (p != corners) {
                skip(*p);
                continue;
            }
            polygon.clear();
            for (std::uint64_t left = length(*p->count, p->type); left > 0; --left) {
                const double index = number(p->type);
                if (!(index >= 0 && index < std::numeric_limits<std::uint32_t>::max() && index == double(std::uint32_t(index))))
                    fail("a face names a vertex by what is no index");
                polygon.push_back(std::uint32_t(index));
            }
            addPolygon(mesh_, polygon);
        }
}

Mesh PlyReader::run() {
    readHeader();
    bool vertices = false, faces = false;
    for (const Element& element : elements_) {
        requireRoom(element.count, fewestBytes(element));
        if (element.name == "vertex" && !vertices) {
            readVertices(element);
            vertices = true;
        } else if (element.name == "face" && !faces) {
            readFaces(element);
            faces = true;
        } else {
            skip(element);
        }
    }
    if (!vertices || !faces)
        fail(vertices ? "it has no faces, as point clouds have none" : "it has no vertices");
    for (const glm::uvec3& t : mesh_.triangles)
        if (std::max({t.x, t.y, t.z}) >= mesh_.positions.size())
            fail("a face names a vertex that there is not");
    requireFinite(mesh_, name_);
    return std::move(mesh_);
}

} // namespace

Mesh readPly(const Bytes& file, const std::string& name) { return PlyReader(file, name).run(); }

} // namespace cmpg
