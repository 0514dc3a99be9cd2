<<<<<<< HEAD
//! Files other than the scene's own: what they hold, checked.

pub mod camera_path;
=======
//! Files: what can be loaded.

pub mod image;
>>>>>>> output
