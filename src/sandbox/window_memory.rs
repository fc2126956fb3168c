//! What the window remembers from one time to the next, in a small file of the user's.
//!
//! Nothing is read or written unless somebody names the file: [`launch`](super::launch) does, tests and films do not. Whatever is
//! wrong with it is said in one line, and the window opens as it did the first time.

use std::path::{Path, PathBuf};
use std::{fs, io};

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use serde::{Deserialize, Serialize};

use super::camera::{self, Framing};
use super::panel::{Page, PanelOpen, PanelWidth, PlotsHeight};
use super::recent::RecentFiles;
use super::scale::{InterfaceScale, LEAST_WINDOW};
use super::state::ShowsPlots;
use super::{CurrentScene, Notice};
use crate::lab::write_whole;
use crate::scene;

/// Seconds between two looks at what has changed.
const INTERVAL: f64 = 1.0;
/// Largest side of a window, logical pixels.
const LARGEST: f32 = 16_384.0;

/// What is remembered. What a file lacks is as at the first time, so that one of an older Plumb can be read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowMemory {
    /// Width and height of the window, logical pixels.
    pub size: [f32; 2],
    /// Page of the panel.
    pub page: Page,
    /// Whether the panel is open.
    pub panel_open: bool,
    /// Width of the panel, points.
    pub panel_width: f32,
    /// Whether the plots are on view.
    pub plots: bool,
    /// Height of the plots, points.
    pub plots_height: f32,
    /// Scale of the interface, percent.
    pub scale: u16,
    /// Files that were opened or saved, the newest first.
    pub recent: Vec<String>,
    /// Where the camera was when the window was closed.
    pub view: Option<ViewOfScene>,
}

/// The camera before a built-in scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewOfScene {
    /// Its name.
    pub scene: String,
    /// As on the command line.
    pub parameters: Vec<(String, f64)>,
    /// Where the camera is, m.
    pub eye: [f64; 3],
    /// What it looks at, m.
    pub target: [f64; 3],
}

impl Default for WindowMemory {
    fn default() -> Self {
        Self {
            size: [1280.0, 720.0],
            page: Page::default(),
            panel_open: true,
            panel_width: PanelWidth::default().0,
            plots: false,
            plots_height: PlotsHeight::default().0,
            scale: InterfaceScale::default().0,
            recent: Vec::new(),
            view: None,
        }
    }
}

impl WindowMemory {
    /// What a file says, each number within its range.
    fn read(file: &Path) -> Result<Self, String> {
        let text = match fs::read_to_string(file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            text => text.map_err(|error| error.to_string())?,
        };
        let mut memory: Self = ron::from_str(&text).map_err(|error| error.to_string())?;
        for (side, least) in memory.size.iter_mut().zip(LEAST_WINDOW.to_array()) {
            // Also where it is no number.
            *side = side.max(least).min(LARGEST);
        }
        let usual = Self::default();
        for (side, usual) in
            [(&mut memory.panel_width, usual.panel_width), (&mut memory.plots_height, usual.plots_height)]
        {
            // Too large or too small is for those who draw them to judge.
            *side = if side.is_finite() { *side } else { usual };
        }
        memory.scale = InterfaceScale::nearest(memory.scale).0;
        memory.view = memory.view.filter(ViewOfScene::is_sound);
        Ok(memory)
    }

    /// What a world would be remembered as; where its window is gone, that was so large.
    fn of_world(world: &mut World, size: [f32; 2]) -> Self {
        let window = world.query_filtered::<&Window, With<PrimaryWindow>>().single(world).ok();
        let size = window.map_or(size, |window| window.size().to_array());
        // A file has a view of its own.
        let scene = |current: &&CurrentScene| scene::find(&current.scene).is_some();
        let view = camera::view(world);
        let view = view.zip(world.get_resource().filter(scene)).map(|(view, current)| ViewOfScene {
            scene: current.scene.clone(),
            parameters: current.parameters.clone(),
            eye: view.eye.to_array(),
            target: view.target.to_array(),
        });
        Self {
            size,
            page: *world.resource::<Page>(),
            panel_open: world.resource::<PanelOpen>().0,
            panel_width: world.resource::<PanelWidth>().0,
            plots: world.resource::<ShowsPlots>().0,
            plots_height: world.resource::<PlotsHeight>().0,
            scale: world.resource::<InterfaceScale>().0,
            recent: world.resource::<RecentFiles>().0.clone(),
            view,
        }
    }

    /// Makes a world, but for its window, what is remembered.
    fn put_in(&self, world: &mut World) {
        world.insert_resource(self.page);
        world.insert_resource(PanelOpen(self.panel_open));
        world.insert_resource(PanelWidth(self.panel_width));
        world.insert_resource(ShowsPlots(self.plots));
        world.insert_resource(PlotsHeight(self.plots_height));
        world.insert_resource(InterfaceScale(self.scale));
        world.insert_resource(RecentFiles(self.recent.clone()));
    }

    /// Whether there is something to be written: a camera that moves alone is none.
    fn differs(&self, other: &Self) -> bool {
        *self != Self { view: self.view.clone(), ..other.clone() }
    }
}

impl ViewOfScene {
    fn is_sound(&self) -> bool {
        self.eye != self.target && self.eye.iter().chain(&self.target).all(|number| number.is_finite())
    }
}

/// The file in which the window is remembered, and what it says.
#[derive(Resource, Clone, Debug)]
pub struct MemoryFile {
    path: PathBuf,
    memory: WindowMemory,
    /// What is still to be said of it.
    problem: Option<String>,
    /// The camera, until the scene that it is of is on view.
    view: Option<ViewOfScene>,
    /// When it was last compared with the world, s of the real clock.
    last_look: f64,
    /// A file that cannot be written is said to be so once.
    is_unwritable: bool,
}

impl MemoryFile {
    /// Reads the file, if it is there.
    pub fn read(path: &Path) -> Self {
        let (memory, problem) = match WindowMemory::read(path) {
            Ok(memory) => (memory, None),
            Err(reason) => {
                let said = format!("{}: {reason}; the window opens as at the first time", path.display());
                (WindowMemory::default(), Some(said))
            }
        };
        let view = memory.view.clone();
        Self { path: path.to_owned(), memory, problem, view, last_look: 0.0, is_unwritable: false }
    }

    /// What it said.
    pub fn memory(&self) -> &WindowMemory {
        &self.memory
    }

    /// Makes the sandbox what is remembered, and has it remembered from now on. The window is for the caller to open.
    pub fn put_in(self, app: &mut App) {
        self.memory.put_in(app.world_mut());
        app.insert_resource(self)
            .add_systems(PostUpdate, recall.run_if(resource_added::<CurrentScene>))
            .add_systems(Last, remember.run_if(is_due));
    }

    fn write(&mut self) -> Result<(), String> {
        let write = || {
            let text =
                ron::ser::to_string_pretty(&self.memory, ron::ser::PrettyConfig::new()).map_err(io::Error::other)?;
            if let Some(folder) = self.path.parent() {
                fs::create_dir_all(folder)?;
            }
            write_whole(&self.path, &(text + "\n"))
        };
        write().map_err(|error| format!("{}: cannot be written: {error}", self.path.display()))
    }
}

/// The file of whoever runs the program, where the system has a place for such: `XDG_CONFIG_HOME`, else `~/.config`, on Linux.
pub(super) fn users_file() -> Option<PathBuf> {
    let folder = |variable: &str| std::env::var_os(variable).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let settings = if cfg!(windows) {
        folder("APPDATA")
    } else if cfg!(target_os = "macos") {
        folder("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")))
    };
    Some(settings?.join("plumb").join("window.ron"))
}

/// With the first scene: the camera is where it was left, if it was before the same one.
fn recall(world: &mut World) {
    let mut file = world.resource_mut::<MemoryFile>();
    let (view, problem) = (file.view.take(), file.problem.take());
    let scene = world.resource::<CurrentScene>();
    if let Some(view) = view.filter(|view| (&view.scene, &view.parameters) == (&scene.scene, &scene.parameters)) {
        let [eye, target] = [view.eye, view.target].map(DVec3::from_array);
        camera::look(world, Framing { eye, target });
    }
    if let Some(problem) = problem {
        *world.resource_mut::<Notice>() = Notice::Error(problem);
    }
}

/// Now and then, and when the window is closed.
fn is_due(clock: Res<Time<Real>>, exits: Res<Messages<AppExit>>, file: Res<MemoryFile>) -> bool {
    !exits.is_empty() || clock.elapsed_secs_f64() - file.last_look >= INTERVAL
}

fn remember(world: &mut World) {
    let clock = world.resource::<Time<Real>>().elapsed_secs_f64();
    world.resource_mut::<MemoryFile>().last_look = clock;
    let is_exiting = !world.resource::<Messages<AppExit>>().is_empty();
    let size = world.resource::<MemoryFile>().memory.size;
    let now = WindowMemory::of_world(world, size);
    let mut file = world.resource_mut::<MemoryFile>();
    let is_news = now.differs(&file.memory) || is_exiting && now != file.memory;
    if !is_news {
        return;
    }
    file.memory = now;
    if let Err(reason) = file.write()
        && !std::mem::replace(&mut file.is_unwritable, true)
    {
        *world.resource_mut::<Notice>() = Notice::Error(reason);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> WindowMemory {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("window.ron");
        fs::write(&path, text).unwrap();
        WindowMemory::read(&path).unwrap()
    }

    #[test]
    fn what_a_file_lacks_is_as_at_the_first_time_and_numbers_are_in_range() {
        assert_eq!(read("()"), WindowMemory::default());
        assert_eq!(read("(from_a_later_plumb: 7, page: Solver)").page, Page::Solver);
        assert_eq!(read("(size: (1, 1e9))").size, [LEAST_WINDOW.x, LARGEST]);
        assert_eq!(read("(size: (NaN, 400))").size, [LEAST_WINDOW.x, 400.0]);
        assert_eq!(read("(panel_width: inf, plots_height: NaN)"), WindowMemory::default());
        assert_eq!(read("(scale: 9999)").scale, 200);
        let at_itself = "(view: Some((scene: \"limbs\", parameters: [], eye: (1, 1, 1), target: (1, 1, 1))))";
        assert_eq!(read(at_itself).view, None);
    }

    #[test]
    fn a_camera_that_moves_is_no_reason_to_write() {
        let view = ViewOfScene { scene: "limbs".into(), parameters: Vec::new(), eye: [1.0; 3], target: [0.0; 3] };
        let moved = WindowMemory { view: Some(view), ..default() };
        assert!(!moved.differs(&WindowMemory::default()));
        assert!(WindowMemory { scale: 150, ..moved }.differs(&WindowMemory::default()));
    }
}
