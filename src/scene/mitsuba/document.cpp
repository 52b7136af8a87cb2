// From the text of an XML file to elements: limits, variables, included files, older names.
#include "scene/mitsuba/document.h"

#include "base/error.h"
#include "scene/contained_path.h"
#include "scene/mitsuba/colors.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <pugixml.hpp>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

constexpr std::uintmax_t kMaxXmlBytes = std::uintmax_t(256) << 20;
constexpr std::size_t kMaxElements = std::size_t(1) << 20; // with included files, each time they are included
constexpr int kMaxDepth = 64, kMaxIncludes = 15;
constexpr double kCurrentVersion = 3;
constexpr std::size_t kMaxValue = std::size_t(1) << 16; // of an attribute, variables replaced

constexpr const char* kObjects[] = {"bsdf", "texture", "shape", "emitter", "sensor", "film", "rfilter", "sampler", "integrator", "medium", "phase", "volume"};

// toWorld -> to_world, intIOR -> int_ior, as version 2 renamed all properties.
std::string snakeCase(const std::string& name) {
    std::string out;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto c = static_cast<unsigned char>(name[i]);
        if (std::isupper(c) && i > 0 && !std::isupper(static_cast<unsigned char>(name[i - 1])) && name[i - 1] != '_')
            out += '_';
        out += char(std::tolower(c));
    }
    return out;
}

// Names that versions 0.6 and 2 had for the same thing.
std::string currentTag(const std::string& tag) {
    if (tag == "camera")
        return "sensor";
    if (tag == "luminaire")
        return "emitter";
    if (tag == "lookAt" || tag == "look_at")
        return "lookat";
    return tag;
}

bool isName(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

} // namespace

const std::string* MitsubaElement::attribute(const std::string& key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? nullptr : &found->second;
}

class MitsubaDocument::Reader {
  public:
    explicit Reader(MitsubaDocument& document) : d_(document) {}
    // What stands in the file becomes children of `parent`.
    void file(const fs::path& path, const std::string& name, MitsubaElement& parent, int depth, int includes);

  private:
    void children(const pugi::xml_node& node, MitsubaElement& parent, std::uint32_t file, int depth, int includes);
    std::string substituted(std::string text, const MitsubaElement& element) const;
    void define(const MitsubaElement& element);
    void fillOldDefaults(MitsubaElement& element);

    MitsubaDocument& d_;
};

void MitsubaDocument::Reader::file(const fs::path& path, const std::string& name, MitsubaElement& parent, int depth, int includes) {
    const Bytes bytes = readFile(path, kMaxXmlBytes);
    const auto index = std::uint32_t(d_.files_.size());
    File& file = d_.files_.emplace_back();
    file.name = name;
    file.path = fs::weakly_canonical(path);
    for (std::size_t i = 0; i < bytes.size(); ++i)
        if (bytes[i] == '\n')
            file.lines.push_back(i);
    pugi::xml_document xml;
    const pugi::xml_parse_result result = xml.load_buffer(bytes.data(), bytes.size(), pugi::parse_default, pugi::encoding_utf8);
    MitsubaElement at;
    at.file = index;
    const auto locate = [&](std::ptrdiff_t offset) {
        at.offset = std::size_t(std::max<std::ptrdiff_t>(offset, 0));
        at.line = std::uint32_t(std::lower_bound(file.lines.begin(), file.lines.end(), at.offset) - file.lines.begin()) + 1;
    };
    if (!result) {
        locate(result.offset);
        d_.fail(at, std::string("this is not XML: ") + result.description(), "the file is truncated, damaged, or not a Mitsuba scene",
                "check the file in an editor");
    }
    const pugi::xml_node root = xml.document_element();
    locate(root.offset_debug());
    if (std::strcmp(root.name(), "scene") != 0)
        d_.fail(at, "<" + std::string(root.name()).substr(0, 64) + "> is no scene", "it is another kind of XML file", "name a file whose root is <scene>");
    file.old = root.attribute("version").as_double(kCurrentVersion) < 2; // 0.6.0 is read as 0.6
    children(root, parent, index, depth, includes);
}

std::string MitsubaDocument::Reader::substituted(std::string text, const MitsubaElement& element) const {
    for (std::size_t at = text.find('$'); at != std::string::npos; at = text.find('$', at)) {
        std::size_t end = at + 1;
        while (end < text.size() && isName(text[end]))
            ++end;
        // The longest variable that the text begins with: "$scene_1" may be $scene followed by _1.
        std::string name = text.substr(at + 1, end - at - 1);
        while (!name.empty() && !d_.variables_.contains(name))
            name.pop_back();
        if (name.empty())
            d_.fail(element, "the variable " + text.substr(at, end - at) + " has no value", "no <default> above gives it one",
                    "give it: --define " + text.substr(at + 1, end - at - 1) + "=VALUE");
        d_.used_.insert(name);
        const std::string& value = d_.variables_.at(name);
        text.replace(at, name.size() + 1, value);
        at += value.size(); // a value is not looked at again
        if (text.size() > kMaxValue)
            d_.fail(element, "a value is too long with its variables replaced", "the file is damaged", "shorten it");
    }
    return text;
}

void MitsubaDocument::Reader::define(const MitsubaElement& element) {
    const std::string* value = element.attribute("value");
    if (element.name.empty() || !value)
        d_.fail(element, "<default> needs name and value");
    d_.used_.insert(element.name);
    d_.variables_.try_emplace(element.name, *value); // what was given beside the scene, or above, stays
}

// Metals were copper, and are perfect mirrors since version 2. The element also tells Mitsuba 3, where the scene is written back.
void MitsubaDocument::Reader::fillOldDefaults(MitsubaElement& element) {
    if (element.tag != "bsdf" || (element.type != "conductor" && element.type != "roughconductor"))
        return;
    for (const MitsubaElement* child : element.children)
        if (child->name == "material" || child->name == "eta" || child->name == "k")
            return;
    MitsubaElement& material = d_.elements_.emplace_back();
    material.tag = "string";
    material.name = "material";
    material.attributes["value"] = "Cu";
    material.file = element.file;
    material.line = element.line;
    element.children.push_back(&material);
}

void MitsubaDocument::Reader::children(const pugi::xml_node& node, MitsubaElement& parent, std::uint32_t file, int depth, int includes) {
    for (const pugi::xml_node& child : node.children()) {
        if (child.type() != pugi::node_element)
            continue;
        MitsubaElement& element = d_.elements_.emplace_back();
        element.tag = currentTag(child.name());
        element.file = file;
        element.offset = std::size_t(std::max<std::ptrdiff_t>(child.offset_debug(), 0));
        const std::vector<std::size_t>& lines = d_.files_[file].lines;
        element.line = std::uint32_t(std::lower_bound(lines.begin(), lines.end(), element.offset) - lines.begin()) + 1;
        if (depth > kMaxDepth)
            d_.fail(element, "elements are nested too deeply", "the file is damaged", "at most " + std::to_string(kMaxDepth) + " levels are read");
        if (d_.elements_.size() > kMaxElements)
            d_.fail(element, "the scene has more than " + std::to_string(kMaxElements) + " elements", "files include each other",
                    "divide the scene");
        for (const pugi::xml_attribute& attribute : child.attributes()) {
            const std::string key = attribute.name();
            std::string value = substituted(attribute.value(), element);
            if (key == "type")
                element.type = std::move(value);
            else if (key == "name")
                element.name = element.tag == "default" ? std::move(value) : snakeCase(value);
            else if (key == "id" && element.tag != "ref" && element.tag != "alias")
                element.id = std::move(value);
            else
                element.attributes[key] = std::move(value);
        }
        if (element.tag == "default") {
            define(element);
            continue;
        }
        if (element.tag == "include") {
            const std::string* name = element.attribute("filename");
            if (!name)
                d_.fail(element, "<include> needs a filename");
            if (includes >= kMaxIncludes)
                d_.fail(element, "files include each other too deeply", "a file includes itself", "at most " + std::to_string(kMaxIncludes) + " levels are read");
            // Beside the file that includes it, as Mitsuba finds it, else beside the scene.
            const fs::path beside = d_.files_[file].path.parent_path().lexically_relative(d_.folder_) / *name;
            const ContainedPath near = containedPath(d_.folder_, beside.generic_string());
            const fs::path path = near.refusal.empty() && fileExists(near.file) ? near.file : d_.path(element, *name);
            if (!fileExists(path))
                d_.fail(element, "there is no file " + *name, "it was moved, renamed or left behind", "copy the whole folder of the scene");
            this->file(path, *name, parent, depth, includes + 1);
            continue;
        }
        if (element.tag == "alias") {
            const std::string *id = element.attribute("id"), *as = element.attribute("as");
            if (!id || !as || !d_.ids_.contains(*id))
                d_.fail(element, "<alias> needs the id of something above, and another as");
            d_.ids_[*as] = d_.ids_[*id];
            continue;
        }
        if (element.tag == "path")
            d_.fail(element, "<path> is not supported", "scenes may only name files inside their own folder", "name files relative to the scene");
        const bool object = std::find(std::begin(kObjects), std::end(kObjects), element.tag) != std::end(kObjects);
        if (object && element.type.empty())
            d_.fail(element, "<" + element.tag + "> needs a type");
        if (!element.id.empty() && !d_.ids_.try_emplace(element.id, &element).second)
            d_.fail(element, "the id " + element.id + " is given twice", "two parts of the scene were merged", "rename one of them");
        children(child, element, file, depth + 1, includes);
        becomeRgb(d_, element);
        if (d_.files_[file].old)
            fillOldDefaults(element);
        parent.children.push_back(&element);
    }
}

MitsubaDocument::MitsubaDocument(const fs::path& file, const std::map<std::string, std::string>& definitions) : variables_(definitions) {
    for (const auto& [name, value] : definitions)
        given_.insert(name);
    Reader reader(*this);
    if (fileExists(file)) // a link to a scene stands for the scene itself: its neighbours are where it really lies
        folder_ = fs::canonical(file).parent_path();
    reader.file(file, file.string(), root_, 0, 0);
}

const MitsubaElement* MitsubaDocument::target(const MitsubaElement& ref) const {
    const std::string* id = ref.attribute("id");
    const auto found = id ? ids_.find(*id) : ids_.end();
    return found == ids_.end() ? nullptr : found->second;
}

const MitsubaElement& MitsubaDocument::resolve(const MitsubaElement& element) const {
    if (element.tag != "ref")
        return element;
    const std::string* id = element.attribute("id");
    const MitsubaElement* found = target(element);
    if (!found)
        fail(element, id ? "nothing in the scene has the id " + *id : "<ref> needs an id", "it is misspelt, or its definition was left behind",
             "define it in the scene");
    return *found;
}

std::vector<std::string> MitsubaDocument::unusedDefinitions() const {
    std::vector<std::string> unused;
    std::set_difference(given_.begin(), given_.end(), used_.begin(), used_.end(), std::back_inserter(unused));
    return unused;
}

std::string MitsubaDocument::place(const MitsubaElement& element) const {
    return (element.file < files_.size() ? files_[element.file].name : name()) + ":" + std::to_string(element.line);
}

void MitsubaDocument::fail(const MitsubaElement& element, const std::string& what, const std::string& cause, const std::string& remedy) const {
    throw Error(ErrorKind::Input, place(element) + ": " + what, cause, remedy);
}

fs::path MitsubaDocument::path(const MitsubaElement& element, const std::string& relative) const {
    const ContainedPath path = containedPath(folder_, relative);
    if (!path.refusal.empty())
        fail(element, "names \"" + relative + "\", " + path.refusal, path.cause, path.remedy);
    return path.file;
}

std::vector<fs::path> MitsubaDocument::files() const {
    std::vector<fs::path> files;
    for (const File& file : files_)
        files.push_back(file.path);
    std::set<std::string> names;
    for (const MitsubaElement& element : elements_)
        if (element.tag == "string" && element.name == "filename" && element.attribute("value"))
            names.insert(*element.attribute("value"));
    for (const std::string& name : names)
        if (const ContainedPath path = containedPath(folder_, name); path.refusal.empty())
            files.push_back(path.file);
    return files;
}

Bytes MitsubaDocument::read(const MitsubaElement& element, const std::string& relative) const {
    const fs::path file = path(element, relative);
    try {
        return readFile(file);
    } catch (const Error& e) {
        throw Error(e.kind, place(element) + ": " + e.what(), "a file of the scene was moved, renamed or left behind", "copy the whole folder of the scene");
    }
}

} // namespace cmpg
