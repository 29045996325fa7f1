"""The coupled system as one component: wheel, rail and contact with their own order of stepping and their own step."""
