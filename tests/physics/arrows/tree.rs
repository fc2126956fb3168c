//! The modules of a crate, the names that each binds and the paths that each mentions; which file a path leads to.
//!
//! A `use` of a module is no arrow yet: what is then named through it is. Inside macros' token streams every
//! `a::b` counts as a path, as if it stood in the module that contains it.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ImplItem, Item, Meta, Stmt, UseTree};

/// The name under which the binary imports the library.
const CRATE: &str = "plumb";

/// A parsed crate. Modules, files and mentions name each other by index.
#[derive(Default)]
pub struct Tree {
    /// Paths from the root of the sources; those that only tests need included.
    pub files: Vec<String>,
    pub modules: Vec<Module>,
    pub mentions: Vec<Mention>,
    /// What could not be read.
    pub problems: Vec<String>,
}

/// A file or a `mod name { … }` in one.
pub struct Module {
    pub file: usize,
    /// From the crate's root, which is empty.
    pub path: Vec<String>,
    parent: Option<usize>,
    is_test: bool,
    /// A type, a function and a module may share a name.
    bindings: BTreeMap<String, Vec<Binding>>,
}

#[derive(Clone)]
enum Binding {
    Item,
    Macro,
    Module(usize),
    Import(Vec<String>),
}

/// A path as it is written, `use` trees taken apart.
pub struct Mention {
    pub module: usize,
    pub path: Vec<String>,
    pub is_test: bool,
    /// Starts with `::`.
    pub from_outside: bool,
    /// `path::*`, the star left out.
    pub is_glob: bool,
    /// `name!` without a path.
    is_macro: bool,
}

/// What a path leads to: a module, or an item by the file that defines it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Target {
    Module(usize),
    File(usize),
}

impl Tree {
    /// Reads the crate from its roots `lib.rs` and `main.rs` on. `sources`: text by path from the root.
    pub fn parse(sources: &BTreeMap<String, String>) -> Self {
        let mut tree = Self::default();
        for root in ["lib.rs", "main.rs"].into_iter().filter(|&root| sources.contains_key(root)) {
            let module = tree.add_file(root, Vec::new(), None, false);
            read_file(&mut tree, sources, module);
        }
        let declared: BTreeSet<&String> = tree.files.iter().collect();
        let lost = sources.keys().filter(|file| !declared.contains(file));
        let lost: Vec<String> = lost.map(|file| format!("src/{file}: no module declares it")).collect();
        tree.problems.extend(lost);
        tree
    }

    fn add_file(&mut self, name: &str, path: Vec<String>, parent: Option<usize>, is_test: bool) -> usize {
        self.files.push(name.into());
        self.add_module(self.files.len() - 1, path, parent, is_test)
    }

    fn add_module(&mut self, file: usize, path: Vec<String>, parent: Option<usize>, is_test: bool) -> usize {
        self.modules.push(Module { file, path, parent, is_test, bindings: BTreeMap::new() });
        self.modules.len() - 1
    }

    /// The files that define what a mention leads to; none where that is a module or another crate's.
    pub fn files_of(&self, mention: &Mention) -> Vec<usize> {
        if mention.is_macro {
            return self.macro_file(mention.module, &mention.path[0]).into_iter().collect();
        }
        let file = |target| if let Target::File(file) = target { Some(file) } else { None };
        // `Type::new`: the import of `Type` is an arrow already.
        if mention.path.len() > 1 && self.targets(mention, 1).into_iter().all(|target| file(target).is_some()) {
            return Vec::new();
        }
        self.targets(mention, mention.path.len()).into_iter().filter_map(file).collect()
    }

    /// True where a path leads anywhere in this crate.
    pub fn is_inside(&self, mention: &Mention) -> bool {
        !self.targets(mention, mention.path.len()).is_empty()
    }

    /// What the first `length` names of a mention lead to.
    fn targets(&self, mention: &Mention, length: usize) -> Vec<Target> {
        if mention.from_outside {
            return Vec::new();
        }
        self.resolve(mention.module, &mention.path[..length], &mut Vec::new())
    }

    /// A `macro_rules` of the module itself or of one around it; an imported one is found by its import.
    fn macro_file(&self, module: usize, name: &str) -> Option<usize> {
        let around = std::iter::successors(Some(module), |&module| self.modules[module].parent);
        let is_macro = |binding: &Binding| matches!(binding, Binding::Macro);
        around
            .map(|module| &self.modules[module])
            .find(|module| module.bindings.get(name).is_some_and(|bindings| bindings.iter().any(is_macro)))
            .map(|module| module.file)
    }

    fn resolve(&self, from: usize, path: &[String], imports: &mut Vec<(usize, String)>) -> Vec<Target> {
        let mut targets = match path[0].as_str() {
            "crate" => vec![Target::Module(self.root(from))],
            "self" => vec![Target::Module(from)],
            "super" => self.modules[from].parent.map(Target::Module).into_iter().collect(),
            name if self.modules[from].bindings.contains_key(name) => self.look_up(from, name, imports),
            CRATE => vec![Target::Module(0)],
            _ => Vec::new(),
        };
        for name in &path[1..] {
            // In the middle of a path a module, where there is one of this name, and not a function.
            if targets.iter().any(|target| matches!(target, Target::Module(_))) {
                targets.retain(|target| matches!(target, Target::Module(_)));
            }
            let next = targets.iter().flat_map(|&target| match target {
                // Of an item, what belongs to it: a variant, an associated function.
                Target::File(_) => vec![target],
                Target::Module(module) if name == "self" => vec![Target::Module(module)],
                Target::Module(module) if name == "super" => {
                    self.modules[module].parent.map(Target::Module).into_iter().collect()
                }
                Target::Module(module) => self.look_up(module, name, imports),
            });
            targets = next.collect();
        }
        targets
    }

    /// A name that nothing binds was made by a macro of that file.
    fn look_up(&self, module: usize, name: &str, imports: &mut Vec<(usize, String)>) -> Vec<Target> {
        let file = self.modules[module].file;
        let Some(bindings) = self.modules[module].bindings.get(name) else { return vec![Target::File(file)] };
        let step = (module, name.to_owned());
        if imports.contains(&step) {
            return Vec::new();
        }
        imports.push(step);
        let targets = bindings.iter().flat_map(|binding| match binding {
            Binding::Item | Binding::Macro => vec![Target::File(file)],
            Binding::Module(child) => vec![Target::Module(*child)],
            Binding::Import(path) => self.resolve(module, path, imports),
        });
        let targets = targets.collect();
        imports.pop();
        targets
    }

    fn root(&self, module: usize) -> usize {
        std::iter::successors(Some(module), |&module| self.modules[module].parent).last().unwrap()
    }
}

/// Parses the file of a module, and those of the modules that it declares.
fn read_file(tree: &mut Tree, sources: &BTreeMap<String, String>, module: usize) {
    let name = tree.files[tree.modules[module].file].clone();
    match syn::parse_file(&sources[&name]) {
        Ok(file) => {
            let is_test = tree.modules[module].is_test || is_for_tests(&file.attrs);
            let folder = match name.rsplit_once('/').map_or(("", name.as_str()), |split| split) {
                (folder, "mod.rs") => folder.to_owned(),
                ("", "lib.rs" | "main.rs") => String::new(),
                _ => name.trim_end_matches(".rs").to_owned(),
            };
            Reader { tree, sources, module, folder, is_test, blocks: Vec::new() }.visit_file(&file);
        }
        Err(error) => tree.problems.push(format!("src/{name}: {error}")),
    }
}

/// Walks one file.
struct Reader<'a> {
    tree: &'a mut Tree,
    sources: &'a BTreeMap<String, String>,
    module: usize,
    /// Where the files of the module's children lie.
    folder: String,
    is_test: bool,
    /// Names that the blocks around bind; `None` for items of the block itself.
    blocks: Vec<BTreeMap<String, Option<Vec<String>>>>,
}

impl Reader<'_> {
    fn bind(&mut self, name: String, binding: Binding) {
        // What tests bind nobody else sees, and what tests import makes no arrow.
        if !self.is_test && self.blocks.is_empty() {
            self.tree.modules[self.module].bindings.entry(name).or_default().push(binding);
        }
    }

    fn mention(&mut self, path: Vec<String>, from_outside: bool, is_glob: bool) {
        let local = self.blocks.iter().rev().find_map(|block| block.get(&path[0]));
        let path = match local {
            Some(Some(import)) if path.len() > 1 || is_glob => import.iter().chain(&path[1..]).cloned().collect(),
            Some(None) => return,
            _ => path,
        };
        let (module, is_test) = (self.module, self.is_test);
        self.tree.mentions.push(Mention { module, path, is_test, from_outside, is_glob, is_macro: false });
    }

    fn mention_macro(&mut self, name: String) {
        let (module, is_test) = (self.module, self.is_test);
        let mention =
            Mention { module, path: vec![name], is_test, from_outside: false, is_glob: false, is_macro: true };
        self.tree.mentions.push(mention);
    }

    /// Visits with the test flag set where the attributes ask for it.
    fn under(&mut self, attributes: &[Attribute], visit: impl FnOnce(&mut Self)) {
        let outer = self.is_test;
        self.is_test |= is_for_tests(attributes);
        visit(self);
        self.is_test = outer;
    }

    fn child_file(&mut self, name: &str) -> Option<String> {
        let stem = if self.folder.is_empty() { name.to_owned() } else { format!("{}/{name}", self.folder) };
        let found =
            [format!("{stem}.rs"), format!("{stem}/mod.rs")].into_iter().find(|it| self.sources.contains_key(it));
        if found.is_none() {
            self.tree.problems.push(format!("src/{stem}.rs: declared, but not there"));
        }
        found
    }

    /// Every `a::b` among the tokens of a macro, with `prefix` before the first.
    fn scan(&mut self, tokens: TokenStream, prefix: &[String]) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let is_punct =
            |at: usize, mark: char| matches!(tokens.get(at), Some(TokenTree::Punct(p)) if p.as_char() == mark);
        let is_colons = |at: usize| is_punct(at, ':') && is_punct(at + 1, ':');
        let mut at = 0;
        while at < tokens.len() {
            match &tokens[at] {
                TokenTree::Group(group) => {
                    self.scan(group.stream(), &[]);
                    at += 1;
                }
                TokenTree::Ident(_) => {
                    // `::name` is another crate's, or goes on from a type: `<T>::name`. `$name` is a macro's own.
                    let from_outside = at >= 2 && is_colons(at - 2);
                    let is_argument = at >= 1 && is_punct(at - 1, '$');
                    let mut path = prefix.to_vec();
                    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
                        path.push(name.to_string());
                        at += 1;
                        if !is_colons(at) {
                            break;
                        }
                        at += 2;
                        if let Some(TokenTree::Group(group)) = tokens.get(at)
                            && group.delimiter() == Delimiter::Brace
                        {
                            self.scan(group.stream(), &path);
                            at += 1;
                        }
                    }
                    if is_argument && path[0] != "crate" {
                        continue;
                    }
                    if path.len() > 1 {
                        self.mention(path, from_outside, false);
                    } else if is_punct(at, '!') {
                        self.mention_macro(path.remove(0));
                    }
                }
                _ => at += 1,
            }
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        self.under(attributes(item), |reader| {
            match item {
                Item::Macro(it) => {
                    if let Some(name) = &it.ident {
                        reader.bind(name.to_string(), Binding::Macro);
                    }
                }
                Item::Mod(_) | Item::Use(_) => {}
                _ => {
                    if let Some(name) = name_of(item) {
                        reader.bind(name, Binding::Item);
                    }
                }
            }
            visit::visit_item(reader, item);
        });
    }

    fn visit_impl_item(&mut self, item: &'ast ImplItem) {
        let attributes: &[Attribute] = match item {
            ImplItem::Const(it) => &it.attrs,
            ImplItem::Fn(it) => &it.attrs,
            ImplItem::Type(it) => &it.attrs,
            ImplItem::Macro(it) => &it.attrs,
            _ => &[],
        };
        self.under(attributes, |reader| visit::visit_impl_item(reader, item));
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let name = item.ident.to_string();
        let parent = &self.tree.modules[self.module];
        let path: Vec<String> = parent.path.iter().cloned().chain([name.clone()]).collect();
        let (file, outer, is_test) = (parent.file, self.module, self.is_test);
        if let Some((_, items)) = &item.content {
            let child = self.tree.add_module(file, path, Some(outer), is_test);
            self.bind(name.clone(), Binding::Module(child));
            let inner_folder = if self.folder.is_empty() { name } else { format!("{}/{name}", self.folder) };
            let folder = std::mem::replace(&mut self.folder, inner_folder);
            let blocks = std::mem::take(&mut self.blocks);
            self.module = child;
            for item in items {
                self.visit_item(item);
            }
            (self.module, self.folder, self.blocks) = (outer, folder, blocks);
        } else if let Some(file) = self.child_file(&name) {
            let child = self.tree.add_file(&file, path, Some(outer), is_test);
            self.bind(name, Binding::Module(child));
            read_file(self.tree, self.sources, child);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let from_outside = item.leading_colon.is_some();
        for leaf in leaves(&item.tree) {
            if let Some(name) = leaf.name.filter(|_| !from_outside) {
                self.bind(name, Binding::Import(leaf.path.clone()));
            }
            self.mention(leaf.path, from_outside, leaf.is_glob);
        }
    }

    fn visit_block(&mut self, block: &'ast syn::Block) {
        let mut names = BTreeMap::new();
        for statement in &block.stmts {
            match statement {
                Stmt::Item(Item::Use(item)) => {
                    let named = leaves(&item.tree).into_iter().filter_map(|leaf| Some((leaf.name?, Some(leaf.path))));
                    names.extend(named);
                }
                Stmt::Item(item) => names.extend(name_of(item).map(|name| (name, None))),
                _ => {}
            }
        }
        self.blocks.push(names);
        visit::visit_block(self, block);
        self.blocks.pop();
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.segments.len() > 1 {
            let names = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
            self.mention(names, path.leading_colon.is_some(), false);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        if let Some(name) = call.path.get_ident() {
            self.mention_macro(name.to_string());
        }
        visit::visit_macro(self, call);
        self.scan(call.tokens.clone(), &[]);
    }

    fn visit_meta_list(&mut self, list: &'ast syn::MetaList) {
        visit::visit_meta_list(self, list);
        self.scan(list.tokens.clone(), &[]);
    }

    /// `pub(in crate::a)` says who may look, and uses nothing of it.
    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}
}

/// One name of a `use`.
struct Leaf {
    path: Vec<String>,
    /// What it is called here; `None` for a glob or `as _`.
    name: Option<String>,
    is_glob: bool,
}

fn leaves(tree: &UseTree) -> Vec<Leaf> {
    let mut found = Vec::new();
    take_apart(tree, &mut Vec::new(), &mut found);
    found
}

fn take_apart(tree: &UseTree, prefix: &mut Vec<String>, found: &mut Vec<Leaf>) {
    let path_to = |name: &str| {
        let last = (name != "self" || prefix.is_empty()).then(|| name.to_owned());
        prefix.iter().cloned().chain(last).collect::<Vec<_>>()
    };
    match tree {
        UseTree::Path(it) => {
            prefix.push(it.ident.to_string());
            take_apart(&it.tree, prefix, found);
            prefix.pop();
        }
        UseTree::Name(it) => {
            let path = path_to(&it.ident.to_string());
            found.push(Leaf { name: path.last().cloned(), path, is_glob: false });
        }
        UseTree::Rename(it) => {
            let name = it.rename.to_string();
            let path = path_to(&it.ident.to_string());
            found.push(Leaf { name: (name != "_").then_some(name), path, is_glob: false });
        }
        UseTree::Glob(_) => found.push(Leaf { path: prefix.clone(), name: None, is_glob: true }),
        UseTree::Group(it) => it.items.iter().for_each(|item| take_apart(item, prefix, found)),
    }
}

/// `#[cfg(test)]`, alone or in an `all`.
fn is_for_tests(attributes: &[Attribute]) -> bool {
    let of_test = |attribute: &Attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("cfg") => {
            list.parse_args::<Meta>().is_ok_and(|meta| asks_for_test(&meta))
        }
        _ => false,
    };
    attributes.iter().any(of_test)
}

fn asks_for_test(meta: &Meta) -> bool {
    match meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("all") => {
            let parser = syn::punctuated::Punctuated::<Meta, syn::Token![,]>::parse_terminated;
            list.parse_args_with(parser).is_ok_and(|all| all.iter().any(asks_for_test))
        }
        _ => false,
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(it) => &it.attrs,
        Item::Enum(it) => &it.attrs,
        Item::ExternCrate(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::ForeignMod(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Macro(it) => &it.attrs,
        Item::Mod(it) => &it.attrs,
        Item::Static(it) => &it.attrs,
        Item::Struct(it) => &it.attrs,
        Item::Trait(it) => &it.attrs,
        Item::TraitAlias(it) => &it.attrs,
        Item::Type(it) => &it.attrs,
        Item::Union(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        _ => &[],
    }
}

/// What an item that is neither a module, a macro nor an import is called.
fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(it) => &it.ident,
        Item::Enum(it) => &it.ident,
        Item::Fn(it) => &it.sig.ident,
        Item::Static(it) => &it.ident,
        Item::Struct(it) => &it.ident,
        Item::Trait(it) => &it.ident,
        Item::TraitAlias(it) => &it.ident,
        Item::Type(it) => &it.ident,
        Item::Union(it) => &it.ident,
        _ => return None,
    };
    Some(name.to_string())
}
