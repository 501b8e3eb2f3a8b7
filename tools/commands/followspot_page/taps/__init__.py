"""The ports that the page shows, and how it receives from them in a run that goes on."""
